#include "outputs.h"

#include <unistd.h>

#include <gpsrecon/io/io.h>
#include <gpsrecon/io/output_file.h>
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <utility>

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

/// True if writing to `output` would change what `input` holds. Devices and pipes hold nothing.
bool would_overwrite(const std::string& output, const std::string& input) {
  const std::string written = canonical(output == "-" ? "/dev/stdout" : output);
  const std::string read = canonical(input == "-" ? "/dev/stdin" : input);
  std::error_code error;
  if (!fs::exists(written, error) || !fs::exists(read, error)) return written == read;
  return fs::is_regular_file(read, error) && fs::equivalent(written, read, error);
}

std::string in_words(const NamedFile& file, const char* standard_stream) {
  return file.name + " " + (file.path == "-" ? standard_stream : file.path);
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

Outputs::Outputs(const GlobalOptions& options, std::vector<NamedFile> inputs) : inputs_(std::move(inputs)) {
  inputs_.push_back({"--config", options.config});
  if (options.log_file == "-") throw OptionError("--log-file: expected a file, got '-'");
  plan({"--log-file", options.log_file});
}

Outputs::~Outputs() {
  std::error_code ignored;
  for (const Staged& file : staged_) fs::remove(file.temporary, ignored);
  if (!created_folder_.empty()) fs::remove(created_folder_, ignored);
}

void Outputs::refuse_input(const NamedFile& output) const {
  for (const NamedFile& input : inputs_)
    if (!input.path.empty() && would_overwrite(output.path, input.path))
      throw OptionError(in_words(output, "(standard output)") + " is the same file as " +
                        in_words(input, "(standard input)") + ": inputs are not overwritten");
}

bool Outputs::is_planned(const std::string& target) const {
  return std::any_of(planned_.begin(), planned_.end(), [&](const Planned& other) { return other.target == target; });
}

void Outputs::plan(const NamedFile& output, bool mesh_format) {
  if (output.path.empty()) return;
  refuse_input(output);
  const std::string target = canonical(output.path);
  for (const Planned& other : planned_)
    if (target == other.target && (output.path == "-" || !is_direct(output.path)))
      throw OptionError(in_words(other.file, "(standard output)") + " and " + in_words(output, "(standard output)") +
                        " would go to the same file");
  planned_.push_back({output, target});
  check_writable(output.path, mesh_format);
}

void Outputs::plan_folder(const NamedFile& output, const std::function<bool(const std::string& name)>& is_written) {
  if (output.path.empty()) return;
  refuse_input(output);
  fs::path folder(output.path);
  if (!folder.has_filename()) folder = folder.parent_path();  // "folder/"
  std::error_code not_a_folder;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, not_a_folder))
    if (is_written(entry.path().filename().string())) refuse_input({output.name, entry.path().string()});
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
    context.log(is_planned(file.target) ? LogLevel::info : LogLevel::debug, "wrote " + file.target);
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
