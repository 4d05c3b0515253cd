#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <functional>
#include <string>
#include <vector>

#include "arguments.h"
#include "console.h"

namespace gpsrecon::cli {

/// A file by what the command line calls it, "IN" or "--report", and its path; an empty path stands for no file.
struct NamedFile {
  std::string name, path;
};

/// The output files of a command, of which all appear or none. None of them is a file that the command reads. Each is
/// planned before work begins, staged as a temporary file when its content is known, and committed with the others at
/// the end. "-" is standard output. What is neither a new nor a regular file (standard output, devices, pipes) cannot
/// be renamed to and is written at the commit.
class Outputs {
 public:
  using Writer = std::function<void(const std::string& path)>;

  /// `inputs` are all files that the command reads; the configuration file is another of every command. The log file
  /// is an output like others, but written from the beginning. Throws what plan() throws.
  Outputs(const GlobalOptions& options, std::vector<NamedFile> inputs);
  /// Removes what was not committed.
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  /// Throws OptionError if an input or another planned output is the same file, whatever links and spellings lead to
  /// it; OutputError if it cannot be written, or if `mesh_format` is set and its extension is not one of a mesh.
  void plan(const NamedFile& output, bool mesh_format = false);
  /// A folder for stage(), created with the first file in it if it does not exist (its parent must). `is_written` tells
  /// by the name of a file in it whether it may be written. Throws OptionError if that would be an input.
  void plan_folder(const NamedFile& folder, const std::function<bool(const std::string& name)>& is_written);

  /// Lets `write` write the content of `path`, to a temporary file of the same extension. Throws what it throws. An
  /// empty path does nothing.
  void stage(const std::string& path, const Writer& write);

  /// Lets all staged files appear under their names. Throws Cancelled, if asked for up to now, and OutputError.
  void commit(const RunContext& context);

 private:
  struct Staged {
    std::string temporary, target;
  };
  struct Direct {
    std::string path;
    Writer write;
  };
  void refuse_input(const NamedFile& output) const;
  bool is_planned(const std::string& target) const;

  struct Planned {
    NamedFile file;
    std::string target;
  };
  std::vector<NamedFile> inputs_;
  std::vector<Planned> planned_;
  std::vector<Staged> staged_;
  std::vector<Direct> direct_;
  std::string created_folder_;
};

/// True if the extension is that of a format of meshes that has no place for Gaussians.
bool is_mesh_only(const std::string& path);

/// Warns if the format of `path` has no place for colours or scalars that the mesh has.
void warn_of_losses(const Mesh& mesh, const std::string& path, const Console& console);

/// Writes a text file, or to standard output. Throws OutputError.
void write_text(const std::string& text, const std::string& path);

/// `path` with everything from the last dot of the file name on replaced: ("a/b.obj", ".report.json") ->
/// "a/b.report.json".
std::string beside(const std::string& path, const std::string& ending);

}  // namespace gpsrecon::cli
