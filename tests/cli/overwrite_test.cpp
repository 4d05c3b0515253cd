#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <map>
#include <regex>
#include <sstream>

#include "process.h"

// No command writes to a file that it reads.

namespace gpsrecon::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

/// The arguments of a command that name files, in the order of the command line.
struct FileArguments {
  const char* command;  ///< and options without which it would not take the files; separated by blanks
  std::vector<std::string> inputs, outputs;
};

void PrintTo(const FileArguments& arguments, std::ostream* out) {
  *out << arguments.command;
}

const FileArguments file_arguments[] = {
    {"", {"IN", "--config"}, {"OUT", "--covmesh", "--report", "--html", "--heatmap", "--dump", "--log-file"}},
    {"mixture", {"IN", "--config"}, {"OUT", "--ellipsoids", "--log-file"}},
    {"normals --method csw", {"IN", "--surface", "--mixture", "--config"}, {"OUT", "--log-file"}},
    {"project", {"IN", "--config"}, {"OUT", "--log-file"}},
    {"triangulate", {"MIXTURE", "--config"}, {"OUT", "--log-file"}},
    {"fit", {"COVMESH", "POINTS", "--config"}, {"OUT", "--log-file"}},
    {"infer", {"MESH", "--config"}, {"OUT", "--log-file"}},
    {"covmesh", {"COVMESH", "--config"}, {"OUT", "--log-file"}},
    {"subdivide", {"COVMESH", "--points", "--config"}, {"OUT", "--log-file"}},
    {"compare", {"SHAPE", "REFERENCE", "--config"}, {"--report", "--html", "--heatmap", "--log-file"}},
    {"scan", {"SURFACE", "--config"}, {"OUT", "--truth", "--log-file"}},
    {"info", {"FILE", "--config"}, {"--log-file"}},
};

using Paths = std::map<std::string, std::string>;

std::vector<std::string> command_line(const FileArguments& arguments, const Paths& paths) {
  std::vector<std::string> words = words_of(arguments.command);
  for (const auto* names : {&arguments.inputs, &arguments.outputs})
    for (const std::string& name : *names) {
      if (name.starts_with("--")) words.push_back(name);
      words.push_back(paths.at(name));
    }
  return words;
}

/// All files in a folder and what they hold, links to files followed.
std::map<std::string, std::string> contents(const TemporaryFolder& folder) {
  std::map<std::string, std::string> files;
  for (const std::string& name : names_in(folder))
    files[name] = fs::is_directory(folder / name) ? "" : read_bytes(folder / name);
  return files;
}

class Overwriting : public testing::TestWithParam<FileArguments> {};

/// The table has all there is: what --help calls FILE, and the arguments without names.
TEST_P(Overwriting, every_argument_that_names_a_file_is_tried) {
  std::vector<std::string> expected = GetParam().inputs;
  expected.insert(expected.end(), GetParam().outputs.begin(), GetParam().outputs.end());

  std::vector<std::string> words = words_of(GetParam().command);
  words.emplace_back("--help");
  const std::string help = run(words).out;
  std::vector<std::string> found;
  const std::regex argument("(?:^|\n)  (?:([A-Z]+) |(--[a-z-]+) FILE\\b)");
  for (auto it = std::sregex_iterator(help.begin(), help.end(), argument); it != std::sregex_iterator(); ++it)
    found.push_back((*it)[1].matched ? (*it)[1] : (*it)[2]);
  EXPECT_THAT(found, testing::UnorderedElementsAreArray(expected));
}

/// Two ways to spell the name of the same file, that of the input and that of the output.
struct Spelling {
  std::string input, output;
};

std::vector<Spelling> spellings(const std::string& name, const TemporaryFolder& folder) {
  return {{name, name},
          {name, "./folder/../" + name},
          {name, "missing/../" + name},
          {"folder/../" + name, folder / name},
          {name, "soft.ply"},
          {"soft.ply", name},
          {name, "hard.ply"},
          {"hard.ply", "soft.ply"},
          {"here/" + name, name},
          {"here/soft.ply", "here/here/hard.ply"}};
}

TEST_P(Overwriting, an_input_is_refused_before_anything_is_read) {
  for (const std::string& input : GetParam().inputs)
    for (const std::string& output : GetParam().outputs) {
      TemporaryFolder folder;
      fs::create_directory(folder / "folder");
      fs::create_symlink(".", folder / "here");
      Paths paths;
      for (const std::string& name : GetParam().inputs) {
        paths[name] = "in" + name + ".ply";
        write_bytes(folder / paths[name], "# what " + name + " holds\n");
      }
      for (const std::string& name : GetParam().outputs) paths[name] = "out" + name + ".ply";
      fs::create_symlink(paths[input], folder / "soft.ply");
      fs::create_hard_link(folder / paths[input], folder / "hard.ply");
      const auto before = contents(folder);

      for (const Spelling& same : spellings(paths[input], folder)) {
        paths[input] = same.input;
        paths[output] = same.output;
        const std::vector<std::string> words = command_line(GetParam(), paths);
        const ProcessResult result = run(words, {.folder = folder.path().string()});
        SCOPED_TRACE(testing::PrintToString(words));
        EXPECT_EQ(result.exit_code, 2) << result.err;
        EXPECT_THAT(result.err, StartsWith("gpsrecon: error: " + output + " " + same.output + " is the same file as " +
                                           input + " " + same.input + ": "));
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
        EXPECT_THAT(result.out, IsEmpty());
        EXPECT_EQ(contents(folder), before);
      }
    }
}

INSTANTIATE_TEST_SUITE_P(Commands, Overwriting, testing::ValuesIn(file_arguments), [](const auto& instance) {
  const std::vector<std::string> words = words_of(instance.param.command);
  return words.empty() ? std::string("chain") : words.front();
});

class Overwrite : public testing::Test {
 protected:
  /// Exit code 2, with `message`, and everything as it was.
  void expect_refused(const std::string& line, const std::string& message, ProcessOptions options = {}) {
    const auto before = contents(folder);
    options.folder = folder.path().string();
    const ProcessResult result = run(words_of(line), options);
    EXPECT_EQ(result.exit_code, 2) << line << "\n" << result.err;
    EXPECT_THAT(result.err, HasSubstr(message));
    EXPECT_THAT(result.err, HasSubstr("is the same file as"));
    EXPECT_EQ(contents(folder), before) << line;
  }

  TemporaryFolder folder;
};

TEST_F(Overwrite, companions_of_out_that_nobody_named) {
  write_bytes(folder / "s.covmesh.ply", "ply\n");
  write_bytes(folder / "s.report.json", "0 0 0\n");
  expect_refused("s.covmesh.ply s.obj", "--covmesh s.covmesh.ply is the same file as IN s.covmesh.ply");
  expect_refused("s.report.json s.obj", "--report s.report.json is the same file as IN s.report.json");
  expect_refused("./s.covmesh.ply s.obj --no-report", "--covmesh");
  EXPECT_EQ(run({"s.covmesh.ply", "s.obj", "--no-covmesh"}, {.folder = folder.path().string()}).exit_code, 3);
}

TEST_F(Overwrite, every_one_of_several_inputs) {
  for (const char* name : {"a.ply", "b.ply", "c.ply"}) write_bytes(folder / name, "ply\n");
  expect_refused("info a.ply b.ply c.ply --log-file ./c.ply", "--log-file ./c.ply is the same file as FILE c.ply");
}

TEST_F(Overwrite, outputs_named_in_the_configuration_file) {
  write_bytes(folder / "in.ply", "ply\n");
  write_bytes(folder / "c.toml", "report = in.ply\n");
  write_bytes(folder / "itself.toml", "log-file = './itself.toml'\n");
  expect_refused("in.ply out.ply --config c.toml", "--report in.ply is the same file as IN in.ply");
  expect_refused("in.ply out.ply --config itself.toml",
                 "--log-file ./itself.toml is the same file as --config itself.toml");
}

TEST_F(Overwrite, levels_and_fronts_of_an_earlier_dump) {
  fs::create_directory(folder / "levels");
  fs::create_symlink("levels", folder / "link");
  for (const char* name : {"in.ply", "levels/level-03.mixture.ply", "levels/front-00000100.mesh.ply", "levels/mine.ply",
                           "levels/level-03.ply"})
    write_bytes(folder / name, "ply\n");
  expect_refused("levels/level-03.mixture.ply out.ply --dump levels",
                 "--dump levels/level-03.mixture.ply is the same file as IN levels/level-03.mixture.ply");
  expect_refused("levels/front-00000100.mesh.ply out.ply --dump levels/", "IN levels/front-00000100.mesh.ply");
  expect_refused("levels/level-03.mixture.ply out.ply --dump ./link", "--dump ./link/level-03.mixture.ply");
  // A link of such a name to an input anywhere.
  fs::create_symlink("../in.ply", folder / "levels/level-00.mixture.ply");
  expect_refused("in.ply out.ply --dump levels", "--dump levels/level-00.mixture.ply is the same file as IN in.ply");
  // Other files there are not written.
  for (const char* other : {"levels/mine.ply", "levels/level-03.ply"})
    EXPECT_EQ(run({other, "out.ply", "--dump", "levels"}, {.folder = folder.path().string()}).exit_code, 3) << other;
}

TEST_F(Overwrite, files_that_the_shell_opened) {
  const std::string file = folder / "s.ply";
  write_bytes(file, "0 0 0\n1 0 0\n0 1 0\n");
  expect_refused("mixture - s.ply", "OUT s.ply is the same file as IN (standard input)", {.input_file = file});
  expect_refused("mixture /dev/stdin s.ply", "IN /dev/stdin", {.input_file = file});
  expect_refused("mixture s.ply -", "OUT (standard output) is the same file as IN s.ply", {.output_file = file});
  expect_refused("mixture s.ply /dev/stdout", "OUT /dev/stdout", {.output_file = file});
  expect_refused("info s.ply", "the answer (standard output) is the same file as FILE s.ply", {.output_file = file});
}

TEST_F(Overwrite, files_that_do_not_exist_yet) {
  expect_refused("mixture gone.ply ./gone.ply", "OUT ./gone.ply is the same file as IN gone.ply");
}

TEST_F(Overwrite, equal_contents_and_names_in_other_folders_are_other_files) {
  fs::create_directory(folder / "folder");
  write_bytes(folder / "s.ply", "ply\n");
  write_bytes(folder / "folder/s.ply", "ply\n");
  EXPECT_EQ(run({"mixture", "s.ply", "folder/s.ply"}, {.folder = folder.path().string()}).exit_code, 3);
}

/// What holds nothing is not overwritten.
TEST_F(Overwrite, devices_and_pipes_may_be_read_and_written) {
  const std::string null = "/dev/null";
  EXPECT_EQ(
      run({null, "out.ply", "--covmesh", null, "--report", null, "--html", null, "--log-file", null, "--config", null},
          {.folder = folder.path().string()})
          .exit_code,
      3);
  EXPECT_TRUE(fs::is_character_file(null));
  EXPECT_EQ(run({"mixture", null, null}).exit_code, 3);
  EXPECT_EQ(run({"mixture", "-", "-"}, {.input_file = null, .output_file = null}).exit_code, 3);

  // Past all checks it waits for somebody to write to the pipe.
  const std::string pipe = folder / "pipe.ply";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const ProcessResult waiting = run({"mixture", pipe, pipe}, {.interrupt_after_seconds = 0.5});
  EXPECT_NE(waiting.exit_code, 2) << waiting.err;
  EXPECT_THAT(waiting.err, Not(HasSubstr("same file")));
  EXPECT_TRUE(fs::is_fifo(pipe));
}

}  // namespace
}  // namespace gpsrecon::test
