#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>
#include <sstream>

#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

const std::vector<std::string> commands = {"mixture", "normals",   "project", "triangulate", "fit", "infer",
                                           "covmesh", "subdivide", "compare", "scan",        "info"};

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Usage, version_on_standard_output) {
  const ProcessResult result = run({"--version"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_TRUE(std::regex_match(result.out, std::regex("gpsrecon [0-9]+\\.[0-9]+\\.[0-9]+\n"))) << result.out;
  EXPECT_THAT(result.err, IsEmpty());
}

/// What the OpenMP runtime says of itself when the program is started with these variables.
std::string openmp_settings(std::vector<std::string> environment) {
  environment.emplace_back("OMP_DISPLAY_ENV=VERBOSE");
  return run({"--version"}, {.environment = std::move(environment)}).err;
}

TEST(Usage, waiting_threads_sleep_unless_told_otherwise) {
  const std::string own = openmp_settings({"OMP_WAIT_POLICY", "GOMP_SPINCOUNT", "KMP_BLOCKTIME"});
  if (own.find("GOMP_SPINCOUNT") == std::string::npos) GTEST_SKIP() << "Not GCC's runtime";
  EXPECT_THAT(own, HasSubstr("GOMP_SPINCOUNT = '0'"));
  EXPECT_THAT(openmp_settings({"OMP_WAIT_POLICY=active"}), HasSubstr("OMP_WAIT_POLICY = 'ACTIVE'"));
  const std::string spins = openmp_settings({"OMP_WAIT_POLICY", "GOMP_SPINCOUNT=17"});
  EXPECT_THAT(spins, HasSubstr("GOMP_SPINCOUNT = '17'"));
  EXPECT_THAT(spins, Not(HasSubstr("GOMP_SPINCOUNT = '0'")));
}

TEST(Usage, help_of_every_command) {
  for (const std::string& command : commands) {
    const ProcessResult result = run({command, "--help"});
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_THAT(result.out, StartsWith("Usage: gpsrecon " + command + " "));
    EXPECT_THAT(result.err, IsEmpty());
    for (const std::string& line : lines_of(result.out)) EXPECT_LE(line.size(), 100u) << line;
  }
  const ProcessResult chain = run({"--help"});
  EXPECT_EQ(chain.exit_code, 0);
  EXPECT_THAT(chain.out, StartsWith("Usage: gpsrecon IN OUT [options]\n"));
  for (const std::string& command : commands) EXPECT_THAT(chain.out, HasSubstr(command));
}

/// Options at the start of the lines of a help text, with all of their text up to the next one.
std::map<std::string, std::string> options_of(const std::string& help) {
  std::map<std::string, std::string> options;
  std::string current;
  for (const std::string& line : lines_of(help)) {
    if (line.starts_with("  --")) current = line.substr(2, line.find(' ', 2) - 2);
    if (line.empty()) current.clear();
    if (!current.empty()) options[current] += line + " ";
  }
  return options;
}

TEST(Usage, help_tells_the_default_of_every_option_with_a_value) {
  std::vector<std::vector<std::string>> helps = {{"--help"}};
  for (const std::string& command : commands) helps.push_back({command, "--help"});
  for (const auto& arguments : helps) {
    const auto options = options_of(run(arguments).out);
    EXPECT_GE(options.size(), 9u);
    for (const auto& [name, text] : options) {
      // "  --name VALUE   text", or "  --name   text" for an option without a value.
      if (std::regex_search(text, std::regex("^  --[a-z0-9-]+ [^ ]"))) {
        EXPECT_THAT(text, HasSubstr("default: "));
      }
    }
    EXPECT_TRUE(options.contains("--threads"));
    EXPECT_THAT(options.at("--threads"), HasSubstr("range: [0, 1024]; default: 0"));
    EXPECT_THAT(options.at("--seed"), HasSubstr("default: 1"));
  }
  const auto chain = options_of(run({"--help"}).out);
  EXPECT_THAT(chain.at("--alpha"), HasSubstr("default: 2"));
  EXPECT_THAT(chain.at("--min-dihedral"), HasSubstr("default: 30"));
  EXPECT_THAT(chain.at("--levels"), HasSubstr("default: auto"));
  EXPECT_THAT(chain.at("--initial"), HasSubstr("default: local"));
}

TEST(Usage, manual_has_every_option_and_command) {
  const std::string manual = read_bytes(GPSRECON_SOURCE_DIR "/docs/reference/cli.md");
  std::set<std::string> known;
  std::vector<std::vector<std::string>> helps = {{"--help"}};
  for (const std::string& command : commands) helps.push_back({command, "--help"});
  for (const auto& arguments : helps) {
    EXPECT_THAT(manual, HasSubstr("`gpsrecon " + (arguments.size() > 1 ? arguments[0] + " " : "")));
    for (const auto& [name, text] : options_of(run(arguments).out)) {
      EXPECT_TRUE(manual.find("`" + name) != std::string::npos) << name << " of " << arguments[0];
      known.insert(name);
    }
  }
  // And nothing that is not there.
  const std::regex option("`(--[a-z0-9-]+)");
  for (auto it = std::sregex_iterator(manual.begin(), manual.end(), option); it != std::sregex_iterator(); ++it)
    EXPECT_TRUE(known.contains((*it)[1])) << (*it)[1];
}

/// In processor time, which a busy machine does not lengthen as it does the time on the clock.
TEST(Usage, starts_quickly) {
  double best = 1e9;
  for (int i = 0; i < 5; ++i) best = std::min(best, run({"--version"}).cpu_seconds);
  EXPECT_LE(best, 0.05);
}

struct BadLine {
  const char* arguments;  ///< separated by blanks
  const char* message;    ///< part of it
};

void PrintTo(const BadLine& line, std::ostream* out) {
  *out << line.arguments;
}

class UsageError : public testing::TestWithParam<BadLine> {};

TEST_P(UsageError, is_told_and_exits_with_2) {
  TemporaryFolder folder;
  write_bytes(folder / "in.xyz", "0 0 0\n1 0 0\n0 1 0\n");
  write_bytes(folder / "bad.toml", "alpha = 2\nno-such-key = 3\n");
  write_bytes(folder / "section.toml", "[hem]\nalpha = 2\n");
  write_bytes(folder / "value.toml", "# a comment\n\nalpha = big\n");
  write_bytes(folder / "former.toml", "alpha = 2\ntolerance-rel = 1e-4\n");
  write_bytes(folder / "twice.toml", "alpha = 2\nalpha = 3\n");
  const auto before = names_in(folder);
  const ProcessResult result = run(words_of(GetParam().arguments), {.folder = folder.path().string()});
  EXPECT_EQ(result.exit_code, 2) << result.err;
  EXPECT_THAT(result.err, StartsWith("gpsrecon: error: "));
  EXPECT_THAT(result.err, HasSubstr(GetParam().message));
  EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  EXPECT_THAT(result.out, IsEmpty());
  EXPECT_EQ(names_in(folder), before);
}

constexpr BadLine bad_lines[] = {
    {"", "IN"},
    {"in.xyz", "OUT"},
    {"in.xyz out.ply more", "more"},
    {"prospect in.xyz out.ply", "out.ply"},
    {"mixture", "IN"},
    {"mixture in.xyz", "OUT"},
    {"info", "FILE"},
    {"in.xyz out.ply --no-such-option", "--no-such-option"},
    {"in.xyz out.ply --scheme doo-sabin", "doo-sabin"},
    {"triangulate in.xyz out.ply --alpha 2", "--alpha"},
    {"in.xyz out.ply --alpha", "--alpha"},
    {"in.xyz out.ply --alpha x", "'x'"},
    {"in.xyz out.ply --alpha 2x", "'2x'"},
    {"in.xyz out.ply --alpha 0", "alpha"},
    {"in.xyz out.ply --alpha nan", "--alpha"},
    {"in.xyz out.ply --alpha 11", "alpha"},
    {"in.xyz out.ply --alpha=", "--alpha"},
    {"in.xyz out.ply --detail -1", "detail"},
    {"in.xyz out.ply --detail 101", "detail"},
    {"in.xyz out.ply --sigma0 -10%", "sigma0 must be > 0 or auto, not -10%"},
    {"in.xyz out.ply --sigma0 1mm", "Xsp (sample spacings)"},
    {"in.xyz out.ply --sigma0 1% --detail 2", "contradict"},
    {"in.xyz out.ply --sigma0-rel 0.01", "--sigma0-rel: is now spelled --sigma0 1%"},
    {"in.xyz out.ply --sigma0-rel=0.0003", "is now spelled --sigma0 0.03%"},
    {"in.xyz out.ply --sigma0-rel 0", "is now spelled --sigma0 auto"},
    {"scan shape:sphere s.ply --noise-rel 0.0002", "is now spelled --noise 0.02%"},
    {"in.xyz out.ply --config former.toml", "former.toml:2: tolerance-rel: is now spelled --tolerance 0.01%"},
    {"in.xyz out.ply --budget 3", "budget must be >= 4 or 0, not 3"},
    {"in.xyz out.ply --budget -1", "--budget"},
    {"in.xyz out.ply --budget 100 --max-error 0.1", "contradict"},
    {"in.xyz out.ply --budget 100 --detail 0.5", "contradict"},
    {"in.xyz out.ply --max-error -10%", "max-error must be > 0 or none, not -10%"},
    {"in.xyz out.ply --max-error 10% --sigma0 10%", "contradict"},
    {"mixture in.xyz out.ply --budget 100", "--budget"},
    {"normals in.xyz", "OUT"},
    {"normals in.xyz out.ply --method mean", "pca|weiszfeld|csw"},
    {"normals in.xyz out.ply --neighbors 2", "neighbors"},
    {"normals in.xyz out.ply --support-radius 0", "support-radius"},
    {"normals in.xyz out.ply --support-radius nan", "--support-radius"},
    {"normals in.xyz out.ply --iterations -1", "iterations"},
    {"normals in.xyz out.ply --orient-neighbors 0", "orient-neighbors"},
    {"normals in.xyz out.ply --orient surface", "needs a surface"},
    {"normals in.xyz out.ply --orient sensor", "needs its position"},
    {"normals in.xyz out.ply --orient mst --surface s.ply", "contradicts"},
    {"normals in.xyz out.ply --mixture m.ply", "--mixture"},
    {"normals - out.ply --method csw --mixture -", "standard input"},
    {"in.xyz out.ply --levels 9", "levels"},
    {"in.xyz out.ply --levels -1", "levels must be in [0, 8] or auto, not -1"},
    {"in.xyz out.ply --levels some", "'some'"},
    {"in.xyz out.ply --levels 2 --tolerance 0.1%", "contradict"},
    {"in.xyz out.ply --tolerance -1", "tolerance must be > 0 or none, not -1"},
    {"in.xyz out.ply --fit-steps 101", "steps"},
    {"in.xyz out.ply --fit-steps 1.5", "'1.5'"},
    {"in.xyz out.ply --fit-steps 99999999999", "--fit-steps"},
    {"in.xyz out.ply --hem-levels -1", "hem-levels"},
    {"in.xyz out.ply --target -5", "--target"},
    {"in.xyz out.ply --initial round", "isotropic|local"},
    {"in.xyz out.ply --min-overlap 1", "min-overlap"},
    {"in.xyz out.ply --min-dihedral 180", "min-dihedral"},
    {"in.xyz out.ply --min-component 1", "min-component"},
    {"in.xyz out.ply --min-weight 1", "min-weight"},
    {"in.xyz out.ply --refinements 11", "refinements"},
    {"in.xyz out.ply --refinements -1", "refinements"},
    {"in.xyz out.ply --max-pinhole -1", "max-pinhole"},
    {"in.xyz out.ply --isolation 0.5", "isolation"},
    {"in.xyz out.ply --holes some", "auto, keep, fill:LENGTH or all"},
    {"in.xyz out.ply --holes fill", "auto, keep, fill:LENGTH or all"},
    {"in.xyz out.ply --holes fill:", "expected auto, X% of the diagonal"},
    {"in.xyz out.ply --holes fill:-10%", "holes: the length must be >= 0, not -10%"},
    {"in.xyz out.ply --sensor 1,2", "X,Y,Z"},
    {"in.xyz out.ply --sensor 1,2,3,", "X,Y,Z"},
    {"in.xyz out.ply --corners blunt", "smooth|sharp"},
    {"in.xyz out.ply --threads -1", "threads must be in [0, 1024], not -1"},
    {"in.xyz out.ply --threads 1025", "threads"},
    {"in.xyz out.ply --seed -1", "--seed"},
    {"in.xyz out.ply --progress maybe", "auto|always|never"},
    {"in.xyz out.ply --config missing.toml", "missing.toml"},
    {"in.xyz out.ply --config .", "configuration"},
    {"in.xyz out.ply --config bad.toml", "bad.toml:2: unknown option 'no-such-key'"},
    {"in.xyz out.ply --config section.toml", "section.toml:1"},
    {"in.xyz out.ply --config value.toml", "value.toml:3: alpha: expected a number, got 'big'"},
    {"in.xyz out.ply --config twice.toml", "twice.toml:2: alpha is given twice"},
    {"in.xyz out.ply --covmesh out.ply", "OUT out.ply and --covmesh out.ply would go to the same file"},
    {"in.xyz out.ply --report ./out.ply", "out.ply"},
    {"in.xyz out.ply --report r --covmesh r", "same file"},
    {"in.xyz - --report -", "same file"},
    {"in.xyz out.ply --log-file out.ply", "out.ply"},
    {"in.xyz out.ply --log-file in.xyz", "in.xyz"},
    {"in.xyz out.ply --log-file -", "--log-file"},
    {"in.xyz out.ply --no-report --report r", "--no-report"},
    {"in.xyz out.ply --no-covmesh --covmesh c", "--no-covmesh"},
    {"fit - - out.ply", "standard input"},
    {"mixture in.xyz m.ply --ellipsoids m.ply", "same file"},
};

INSTANTIATE_TEST_SUITE_P(Lines, UsageError, testing::ValuesIn(bad_lines),
                         [](const auto& instance) { return std::to_string(instance.index); });

TEST(Usage, options_may_follow_or_precede_and_the_command_may_follow_global_ones) {
  EXPECT_THAT(run({"--threads", "1", "--quiet", "mixture", "--help"}).out, StartsWith("Usage: gpsrecon mixture"));
  EXPECT_THAT(run({"--threads=1", "mixture", "--help"}).out, StartsWith("Usage: gpsrecon mixture"));
  // After an option of the chain the word is its input.
  EXPECT_EQ(run({"--alpha", "2", "mixture", "/nowhere/out.ply"}).exit_code, 6);
}

}  // namespace
}  // namespace gpsrecon::test
