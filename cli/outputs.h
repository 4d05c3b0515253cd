#pragma once

#include <gpsrecon/core/mesh.h>
#include <gpsrecon/core/run_context.h>
#include <functional>
#include <string>
#include <vector>

#include "arguments.h"
#include "console.h"

namespace gpsrecon::cli {

/// The output files of a command, of which all appear or none. Each is planned before work begins, staged as a
/// temporary file when its content is known, and committed with the others at the end. "-" is standard output. What is
/// neither a new nor a regular file (standard output, devices, pipes) cannot be renamed to and is written at the
/// commit.
class Outputs {
 public:
  using Writer = std::function<void(const std::string& path)>;

  /// The log file of every command is an output like others, but written from the beginning. Throws OptionError if it
  /// is one of the inputs, OutputError if it cannot be written.
  Outputs(const GlobalOptions& options, const std::vector<std::string>& inputs);
  /// Removes what was not committed.
  ~Outputs();
  Outputs(const Outputs&) = delete;
  Outputs& operator=(const Outputs&) = delete;

  /// Throws OptionError if another planned output is the same file; OutputError if it cannot be written, or if
  /// `mesh_format` is set and its extension is not one of a mesh. An empty path stands for no output.
  void plan(const std::string& path, bool mesh_format = false);
  /// A folder for stage(), created with the first file in it if it does not exist (its parent must).
  void plan_folder(const std::string& path);

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
  std::vector<std::string> planned_;
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
