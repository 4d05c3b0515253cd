#include "outputs.h"

#include <unistd.h>

#include <gpsrecon/io/io.h>
#include <gpsrecon/io/output_file.h>
#include <algorithm>
#include <cctype>
#include <filesystem>

namespace gpsrecon::cli {

using namespace internal;
namespace {

namespace fs = std::filesystem;

/// True for what data is written to rather than put in the place of.
bool is_direct(const std::string& path) {
  if (path == "-") return true;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// One spelling per file: links followed, as far as the path exists.
std::string canonical(const std::string& path) {
  if (path == "-") return path;
  std::error_code error;
  const fs::path absolute = fs::weakly_canonical(fs::absolute(path, error), error);
  return error ? path : absolute.string();
}

/// In the folder of the target, so that renaming is atomic, and with its extension, which decides the format.
std::string temporary_for(const std::string& target, std::size_t number) {
  const fs::path path(target);
  const std::string name =
      ".gpsrecon-" + std::to_string(getpid()) + "-staged-" + std::to_string(number) + path.extension().string();
  return (path.parent_path() / name).string();
}

std::string lower_extension(const std::string& path) {
  std::string extension = fs::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace

Outputs::Outputs(const GlobalOptions& options, const std::vector<std::string>& inputs) {
  for (const std::string& input : inputs)
    if (!options.log_file.empty() && canonical(input) == canonical(options.log_file))
      throw OptionError("--log-file: " + input + " is an input");
  if (options.log_file == "-") throw OptionError("--log-file: expected a file, got '-'");
  plan(options.log_file);
}

Outputs::~Outputs() {
  std::error_code ignored;
  for (const Staged& file : staged_) fs::remove(file.temporary, ignored);
  if (!created_folder_.empty()) fs::remove(created_folder_, ignored);
}

void Outputs::plan(const std::string& path, bool mesh_format) {
  if (path.empty()) return;
  const std::string name = canonical(path);
  for (const std::string& other : planned_)
    if (name == other && (path == "-" || !is_direct(path)))
      throw OptionError(path + ": two outputs would go to the same file");
  planned_.push_back(name);
  check_writable(path, mesh_format);
}

void Outputs::plan_folder(const std::string& path) {
  if (path.empty()) return;
  fs::path folder(path);
  if (!folder.has_filename()) folder = folder.parent_path();  // "folder/"
  check_writable((fs::is_directory(folder) ? folder / "level" : folder).string());
}

void Outputs::stage(const std::string& path, const Writer& write) {
  if (path.empty()) return;
  if (is_direct(path)) {
    direct_.push_back({path, write});
    return;
  }
  std::error_code error;
  const fs::path folder = fs::path(path).parent_path();
  if (!folder.empty() && fs::create_directory(folder, error)) created_folder_ = folder.string();
  const std::string target = canonical(path);
  staged_.push_back({temporary_for(target, staged_.size()), target});
  write(staged_.back().temporary);
  const fs::file_status status = fs::status(target, error);
  if (fs::exists(status)) fs::permissions(staged_.back().temporary, status.permissions(), error);
}

void Outputs::commit(const RunContext& context) {
  context.throw_if_cancelled();
  // Direct outputs first: they may fail (a closed pipe), renaming within a folder hardly can.
  for (const Direct& output : direct_) output.write(output.path);
  for (const Staged& file : staged_) {
    std::error_code error;
    fs::rename(file.temporary, file.target, error);
    if (error) throw OutputError(file.target + ": cannot be written: " + error.message());
    const bool is_planned = std::find(planned_.begin(), planned_.end(), file.target) != planned_.end();
    context.log(is_planned ? LogLevel::info : LogLevel::debug, "wrote " + file.target);
  }
  staged_.clear();
  created_folder_.clear();
}

bool is_mesh_only(const std::string& path) {
  const std::string extension = lower_extension(path);
  return extension == ".obj" || extension == ".off" || extension == ".stl" || extension == ".glb";
}

void warn_of_losses(const Mesh& mesh, const std::string& path, const Console& console) {
  const std::string extension = lower_extension(path);
  if (path == "-" || extension == ".ply") return;
  std::string lost = extension == ".stl" && !mesh.colors.empty() ? " colours" : "";
  if (!mesh.covariances.empty()) lost += " covariances";
  for (const ScalarColumn& column : mesh.scalars) lost += " " + column.name;
  if (!lost.empty()) console.warn(path + ": the format has no place for" + lost + "; that of .ply has");
}

void write_text(const std::string& text, const std::string& path) {
  OutputFile file(path);
  file.write(text);
  file.commit();
}

std::string beside(const std::string& path, const std::string& ending) {
  return fs::path(path).replace_extension().string() + ending;
}

}  // namespace gpsrecon::cli
