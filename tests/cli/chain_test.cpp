#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <gpsrecon/io/io.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "../support/json_schema.h"
#include "clouds.h"
#include "process.h"

namespace gpsrecon::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

using Words = std::vector<std::string>;

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// A folder with the cloud "in.ply" and what programs run in it write.
class ChainTest : public testing::Test {
 protected:
  void SetUp() override { write_bytes(folder / "in.ply", ply_of(noisy_sphere(5000, 0.005))); }

  ProcessResult run_here(const Words& words, ProcessOptions options = {}) const {
    options.folder = folder.path().string();
    return run(words, options);
  }
  /// Runs a line that must succeed.
  ProcessResult do_here(const Words& words, const ProcessOptions& options = {}) const {
    ProcessResult result = run_here(words, options);
    EXPECT_EQ(result.exit_code, 0) << testing::PrintToString(words) << "\n" << result.err;
    return result;
  }
  std::string bytes(const std::string& name) const { return read_bytes(folder / name); }
  json info(const std::string& name) const { return json::parse(do_here({"info", "--json", name}).out).at(0); }
  json report(const std::string& name) const { return json::parse(bytes(name)); }

  TemporaryFolder folder;
};

TEST_F(ChainTest, writes_mesh_covmesh_and_report) {
  const ProcessResult result = do_here({"in.ply", "out.ply"});
  EXPECT_THAT(names_in(folder), ElementsAre("in.ply", "out.covmesh.ply", "out.ply", "out.report.json"));
  EXPECT_THAT(result.out, IsEmpty());
  const json mesh = info("out.ply"), covmesh = info("out.covmesh.ply");
  EXPECT_EQ(mesh.at("kind"), "mesh");
  EXPECT_EQ(covmesh.at("kind"), "covmesh");
  EXPECT_EQ(mesh.at("attributes"), json({"normals", "sigma"}));
  for (const json& m : {mesh, covmesh}) {
    EXPECT_EQ(m.at("topology").at("euler"), 2);
    EXPECT_EQ(m.at("topology").at("components"), 1);
    EXPECT_EQ(m.at("topology").at("boundary_loops"), 0);
    EXPECT_TRUE(m.at("topology").at("manifold").get<bool>());
    // The diagonal of the box around the unit sphere.
    EXPECT_NEAR(m.at("diagonal").get<double>(), 2 * std::sqrt(3.0), 0.1);
  }
  // No point is lost without a word.
  double weight = covmesh.at("weight");
  const json counts = report("out.report.json").at("covmesh");
  for (const char* left : {"light_weight", "leftover_weight", "dropped_component_weight"})
    weight += counts.at(left).get<double>();
  EXPECT_NEAR(weight, 5000, 1e-9 * 5000);
}

TEST_F(ChainTest, report_follows_its_schema_and_names_the_input) {
  do_here({"in.ply", "out.ply", "--seed", "7"});
  const json r = report("out.report.json");
  const json schema = json::parse(read_bytes(GPSRECON_SOURCE_DIR "/docs/reference/report.schema.json"));
  EXPECT_THAT(JsonSchema(schema).errors(r), IsEmpty());
  EXPECT_EQ(r.at("schema"), "gpsrecon.report/1");
  EXPECT_EQ(r.at("input").at("file"), "in.ply");
  EXPECT_EQ(r.at("input").at("format"), "ply");
  EXPECT_EQ(r.at("input").at("hash").get<std::string>().size(), 16u);
  EXPECT_EQ(r.at("input").at("points"), 5000);
  EXPECT_EQ(r.at("seed"), 7);
  EXPECT_EQ(r.at("mesh").at("topology").at("nonmanifold_edges"), 0);
  EXPECT_FALSE(r.at("options").empty());
  EXPECT_FALSE(r.at("run").at("stages").empty());
}

TEST_F(ChainTest, a_summary_of_about_ten_lines_on_standard_error) {
  const ProcessResult loud = do_here({"in.ply", "out.ply"});
  EXPECT_THAT(loud.err, HasSubstr("out.ply"));
  const auto lines = std::count(loud.err.begin(), loud.err.end(), '\n');
  EXPECT_GE(lines, 8);
  EXPECT_LE(lines, 30);
  EXPECT_THAT(loud.err, Not(HasSubstr("\r"))) << "a progress bar without a terminal";
  EXPECT_THAT(do_here({"in.ply", "out.ply", "--quiet"}).err, IsEmpty());
  EXPECT_THAT(do_here({"in.ply", "out.ply", "--quiet", "--progress", "always"}).err, HasSubstr("\r"));
}

TEST_F(ChainTest, warnings_even_when_quiet) {
  do_here({"in.ply", "mesh.obj", "--no-report", "--no-covmesh"});
  const ProcessResult result = do_here({"mesh.obj", "again.ply", "--quiet"});
  EXPECT_THAT(result.err, StartsWith("gpsrecon: warning: mesh.obj: is a mesh"));
}

TEST_F(ChainTest, companions_as_asked) {
  do_here({"in.ply", "a.b.off", "--no-covmesh"});
  EXPECT_THAT(names_in(folder), ElementsAre("a.b.off", "a.b.report.json", "in.ply"));
  do_here({"in.ply", "c.stl", "--no-report", "--covmesh", "named.ply"});
  EXPECT_THAT(names_in(folder), ElementsAre("a.b.off", "a.b.report.json", "c.stl", "in.ply", "named.ply"));
  do_here({"in.ply", "d.obj", "--no-covmesh", "--report", "named.json"});
  EXPECT_THAT(names_in(folder),
              ElementsAre("a.b.off", "a.b.report.json", "c.stl", "d.obj", "in.ply", "named.json", "named.ply"));
  EXPECT_EQ(info("named.ply").at("kind"), "covmesh");
  for (const char* mesh : {"a.b.off", "c.stl", "d.obj"}) EXPECT_EQ(info(mesh).at("topology").at("euler"), 2) << mesh;
}

TEST_F(ChainTest, existing_files_are_replaced_and_links_followed) {
  for (const char* name : {"real.ply", "out.covmesh.ply", "out.report.json"}) write_bytes(folder / name, "earlier");
  ::chmod((folder / "real.ply").c_str(), 0600);
  std::filesystem::create_symlink("real.ply", folder / "out.ply");
  do_here({"in.ply", "out.ply"});
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "out.ply"));
  EXPECT_THAT(bytes("real.ply"), StartsWith("ply\n"));
  EXPECT_THAT(bytes("out.covmesh.ply"), StartsWith("ply\n"));
  EXPECT_THAT(bytes("out.report.json"), StartsWith("{"));
  struct stat status {};
  ::stat((folder / "real.ply").c_str(), &status);
  EXPECT_EQ(status.st_mode & 0777u, 0600u);
  EXPECT_EQ(names_in(folder).size(), 5u);
}

TEST_F(ChainTest, standard_input_and_output) {
  do_here({"in.ply", "out.ply"});
  const ProcessResult piped = do_here({"-", "-"}, {.input = bytes("in.ply")});
  EXPECT_EQ(piped.out, bytes("out.ply"));
  EXPECT_EQ(names_in(folder).size(), 4u);
  const ProcessResult with_report = do_here({"-", "-", "--report", "r.json"}, {.input = bytes("in.ply")});
  EXPECT_EQ(with_report.out, bytes("out.ply"));
  EXPECT_EQ(report("r.json").at("input").at("file"), "-");
  // The report alone on standard output.
  const ProcessResult to_stdout = do_here({"in.ply", "o.ply", "--no-covmesh", "--report", "-"});
  EXPECT_EQ(json::parse(to_stdout.out).at("schema"), "gpsrecon.report/1");
}

TEST_F(ChainTest, stages_in_a_pipe) {
  do_here({"in.ply", "out.ply", "--no-fit"});
  const std::string mixture = do_here({"mixture", "in.ply", "-"}).out;
  const std::string covmesh = do_here({"triangulate", "-", "-"}, {.input = mixture}).out;
  const std::string mesh = do_here({"subdivide", "-", "-"}, {.input = covmesh}).out;
  EXPECT_EQ(covmesh, bytes("out.covmesh.ply"));
  EXPECT_EQ(mesh, bytes("out.ply"));
}

TEST_F(ChainTest, closed_pipe_is_an_output_that_cannot_be_written) {
  const ProcessResult result = run_here({"in.ply", "-"}, {.output_is_closed = true});
  EXPECT_EQ(result.exit_code, 6) << result.err;
  EXPECT_EQ(result.signal, 0);
}

TEST_F(ChainTest, devices_are_written_and_not_replaced) {
  do_here({"in.ply", "out.ply", "--covmesh", "/dev/null", "--report", "/dev/null"});
  EXPECT_THAT(names_in(folder), ElementsAre("in.ply", "out.ply"));
  EXPECT_TRUE(std::filesystem::is_character_file("/dev/null"));
}

/// Input, transformed, and options of which each stage command takes its part.
struct Sequence {
  const char* name;
  std::vector<Vec3> (*points)();
  const char *scale, *mixture, *triangulate, *fit, *subdivide;  ///< separated by blanks
};

void PrintTo(const Sequence& sequence, std::ostream* out) {
  *out << sequence.name;
}

std::vector<Vec3> moved(std::vector<Vec3> points, double scale, const Vec3& offset) {
  for (Vec3& p : points) p = scale * p + offset;
  return points;
}

class StagesInSequence : public testing::TestWithParam<Sequence> {};

TEST_P(StagesInSequence, give_the_bytes_of_the_chain) {
  const Sequence& s = GetParam();
  TemporaryFolder folder;
  write_bytes(folder / "in.ply", ply_of(s.points()));
  const ProcessOptions here{.folder = folder.path().string()};
  const auto do_here = [&](const Words& words) {
    const ProcessResult result = run(words, here);
    ASSERT_EQ(result.exit_code, 0) << testing::PrintToString(words) << "\n" << result.err;
  };
  do_here(Words{"in.ply", "chain.ply"} + words_of(s.scale) + words_of(s.mixture) + words_of(s.triangulate) +
          words_of(s.fit) + words_of(s.subdivide));
  do_here(Words{"mixture", "in.ply", "m.ply"} + words_of(s.scale) + words_of(s.mixture));
  do_here(Words{"triangulate", "m.ply", "t.ply"} + words_of(s.triangulate));
  do_here(Words{"fit", "t.ply", "in.ply", "f.ply"} + words_of(s.scale) + words_of(s.fit));
  do_here(Words{"subdivide", "f.ply", "out.ply"} + words_of(s.subdivide));
  EXPECT_GT(read_bytes(folder / "chain.ply").size(), 10000u);
  EXPECT_TRUE(read_bytes(folder / "f.ply") == read_bytes(folder / "chain.covmesh.ply"));
  EXPECT_TRUE(read_bytes(folder / "out.ply") == read_bytes(folder / "chain.ply"));
  EXPECT_FALSE(read_bytes(folder / "t.ply") == read_bytes(folder / "f.ply"));

  // A mixture and a covariance mesh enter the chain at their stages.
  do_here(Words{"f.ply", "from_covmesh.ply"} + words_of(s.subdivide));
  EXPECT_TRUE(read_bytes(folder / "from_covmesh.ply") == read_bytes(folder / "chain.ply"));
  do_here(Words{"m.ply", "from_mixture.ply"} + words_of(s.triangulate) + words_of(s.subdivide));
  EXPECT_TRUE(read_bytes(folder / "from_mixture.covmesh.ply") == read_bytes(folder / "t.ply"));
}

const Sequence sequences[] = {
    {"defaults", [] { return noisy_sphere(5000, 0.005); }, "", "", "", "", ""},
    {"far_from_the_origin", [] { return moved(noisy_torus(6000, 0.005), 25, Vec3(600000.37, 5000000.11, 431.7)); }, "",
     "", "", "", ""},
    {"tiny", [] { return moved(noisy_torus(6000, 0.005), 1e-7, Vec3(1e-6, 0, 0)); }, "", "", "", "", ""},
    {"options", [] { return noisy_torus(6000, 0.01); }, "--isolation 6",
     "--alpha 1.7 --detail 0.9 --hem-levels 3 --balance",
     "--min-overlap 0.02 --min-dihedral 40 --min-weight 0.2 --max-pinhole 6 --holes fill:20% --sensor 1,2,30 "
     "--loop-weights warren --corners sharp",
     "--fit-steps 2 --refinements 1", "--levels 1"},
    {"catmull_clark", [] { return noisy_torus(6000, 0.01); }, "", "", "--scheme catmull-clark", "", ""},
    {"warren", [] { return noisy_torus(6000, 0.01); }, "", "", "--loop-weights warren", "", ""},
    {"sharp_corners", [] { return flat_sheet(70); }, "", "", "--corners sharp", "", ""},
    {"catmull_clark_with_sharp_corners", [] { return flat_sheet(70); }, "", "",
     "--scheme catmull-clark --corners sharp", "", "--levels 1"},
    {"sheet", [] { return flat_sheet(70); }, "", "--target 600", "", "--fit-steps 1", "--levels 0"},
    {"local_start", [] { return noisy_sphere(5000, 0.002); }, "", "--initial local", "", "", "--levels 2"},
};

INSTANTIATE_TEST_SUITE_P(Inputs, StagesInSequence, testing::ValuesIn(sequences),
                         [](const auto& instance) { return std::string(instance.param.name); });

/// A noisy torus as text with a colour, an intensity with gaps, a classification and a number of zones.
std::string colorful_torus() {
  std::string text = "x y z red green blue intensity Classification zone\n";
  char line[200];
  for (const Vec3& p : noisy_torus(6000, 0.005)) {
    const bool missing = std::abs(p.x() - 0.3) < 0.05;
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g %d %d 9 %s %d %d\n", p.x(), p.y(), p.z(),
                  static_cast<int>(127 + 80 * p.x()), static_cast<int>(127 + 80 * p.y()),
                  missing ? "-9999" : std::to_string(3 + p.z()).c_str(), p.x() < 0 ? 2 : 6, p.y() < 0 ? 100 : -100);
    text += line;
  }
  return text;
}

TEST_F(ChainTest, colours_scalars_and_labels_through_all_stages) {
  write_bytes(folder / "c.xyz", colorful_torus());
  const Words columns{"--labels", "ZONE", "--no-data", "-9999"};
  do_here(Words{"c.xyz", "chain.ply", "--levels", "2"} + columns);
  do_here(Words{"mixture", "c.xyz", "m.ply"} + columns);
  do_here({"triangulate", "m.ply", "t.ply"});
  do_here({"fit", "t.ply", "c.xyz", "f.ply"});
  do_here(Words{"subdivide", "f.ply", "out.ply", "--levels", "2", "--points", "c.xyz"} + columns);
  EXPECT_TRUE(bytes("f.ply") == bytes("chain.covmesh.ply"));
  EXPECT_TRUE(bytes("out.ply") == bytes("chain.ply"));
  do_here(Words{"c.xyz", "text.ply", "--levels", "2", "--ascii", "--threads", "3"} + columns);
  do_here(Words{"subdivide", "text.covmesh.ply", "from_text.ply", "--levels", "2", "--points", "c.xyz"} + columns);
  EXPECT_TRUE(bytes("from_text.ply") == bytes("chain.ply"));
  // Without the points, what the Gaussians carry.
  do_here({"subdivide", "f.ply", "coarse.ply", "--levels", "2"});
  do_here({"f.ply", "from_covmesh.ply", "--levels", "2"});
  EXPECT_TRUE(bytes("from_covmesh.ply") == bytes("coarse.ply"));

  for (const char* const name : {"m.ply", "f.ply", "chain.ply", "coarse.ply"}) {
    const json i = info(name);
    for (const char* const attribute : {"colors", "intensity", "Classification", "zone"})
      EXPECT_THAT(i.at("attributes"), testing::Contains(attribute)) << name;
  }
  EXPECT_EQ(info("m.ply").at("labels"), json({"Classification", "zone"}));
  for (const char* const file : {"chain.ply", "coarse.ply"}) {
    const PointCloud vertices = read_points(folder / file);
    const auto column = [&](const std::string& name) {
      return std::find_if(vertices.scalars.begin(), vertices.scalars.end(),
                          [&](const ScalarColumn& c) { return c.name == name; })
          ->values;
    };
    EXPECT_THAT(column("Classification"), testing::Each(testing::AnyOf(2, 6)));
    EXPECT_THAT(column("zone"), testing::Each(testing::AnyOf(100, -100)));
    // Where none of the points around has a number there is none, but nowhere else.
    const std::vector<double> intensity = column("intensity");
    for (std::size_t v = 0; v < vertices.size(); ++v)
      if (!std::isnan(intensity[v]))
        EXPECT_NEAR(intensity[v], 3, 0.5);
      else
        EXPECT_NEAR(vertices.positions[v].x(), 0.3, 0.07);
  }
}

TEST_F(ChainTest, labels_that_cannot_be) {
  write_bytes(folder / "c.xyz", colorful_torus());
  for (const char* const name : {"nowhere", "intensity"}) {
    const ProcessResult result = run_here({"c.xyz", "out.ply", "--labels", name});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(name));
  }
  EXPECT_THAT(names_in(folder), ElementsAre("c.xyz", "in.ply"));
}

TEST_F(ChainTest, formats_without_scalars_are_warned_of) {
  write_bytes(folder / "c.xyz", colorful_torus());
  EXPECT_THAT(do_here({"c.xyz", "out.obj"}).err, AllOf(HasSubstr("no place for intensity"), Not(HasSubstr("colours"))));
  EXPECT_THAT(do_here({"c.xyz", "out.stl"}).err, HasSubstr("no place for colours intensity"));
  EXPECT_EQ(info("out.obj").at("attributes"), json({"normals", "colors"}));
  EXPECT_THAT(do_here({"in.ply", "plain.stl"}).err, Not(HasSubstr("no place")));
}

TEST_F(ChainTest, same_bytes_for_any_number_of_threads) {
  write_bytes(folder / "in.ply", ply_of(noisy_torus(20000, 0.005)));
  std::map<std::string, std::string> first;
  json first_report;
  for (const std::string threads : {"1", "2", "4"}) {
    do_here({"in.ply", "out.ply", "--threads", threads, "--dump", "levels"});
    json r = report("out.report.json");
    EXPECT_EQ(r.at("run").at("threads").get<int>(), std::stoi(threads));
    r.erase("run");
    std::map<std::string, std::string> all;
    for (const std::string& name : names_in(folder))
      if (name != "levels" && name != "out.report.json") all[name] = bytes(name);
    EXPECT_GE(all.size(), 5u);
    if (first.empty()) {
      first = all;
      first_report = r;
    }
    EXPECT_TRUE(all == first) << threads << " threads";
    EXPECT_EQ(r, first_report) << threads << " threads";
  }
}

TEST_F(ChainTest, the_seed_matters) {
  do_here({"mixture", "in.ply", "a.ply"});
  do_here({"mixture", "in.ply", "b.ply", "--seed", "1"});
  do_here({"mixture", "in.ply", "c.ply", "--seed", "2"});
  EXPECT_TRUE(bytes("a.ply") == bytes("b.ply"));
  EXPECT_FALSE(bytes("a.ply") == bytes("c.ply"));
}

TEST_F(ChainTest, options_from_a_configuration_file) {
  write_bytes(folder / "my.toml",
              "# how we scan\nalpha = 1.8   # narrower\n\nlevels = 1\nno-fit = true\nbalance = false\n"
              "loop-weights = \"warren\"\nsensor = [1, 2, 3]\nreport = 'my report.json'\n");
  const Words line = {"--alpha", "1.8", "--levels", "1", "--no-fit", "--loop-weights", "warren", "--sensor", "1,2,3"};
  do_here(Words{"in.ply", "line.ply"} + line);
  do_here({"in.ply", "file.ply", "--config", "my.toml"});
  EXPECT_TRUE(bytes("line.ply") == bytes("file.ply"));
  EXPECT_TRUE(std::filesystem::exists(folder / "my report.json"));
  do_here({"in.ply", "level0.ply", "--config", "my.toml", "--levels", "0"});
  EXPECT_EQ(4 * info("level0.ply").at("topology").at("faces").get<int>(),
            info("file.ply").at("topology").at("faces").get<int>());
}

TEST_F(ChainTest, levels_quadruple_the_faces) {
  for (const int level : {0, 1, 2})
    do_here({"in.ply", std::to_string(level) + ".ply", "--levels", std::to_string(level)});
  const auto faces = [&](const char* name) { return info(name).at("topology").at("faces").get<int>(); };
  EXPECT_EQ(faces("1.ply"), 4 * faces("0.ply"));
  EXPECT_EQ(faces("2.ply"), 16 * faces("0.ply"));
  EXPECT_EQ(faces("0.ply"), faces("0.covmesh.ply"));
}

TEST_F(ChainTest, target_number_of_components) {
  do_here({"mixture", "in.ply", "m.ply", "--target", "400"});
  EXPECT_NEAR(info("m.ply").at("components").get<double>(), 400, 8);
}

TEST_F(ChainTest, text_encoding_holds_the_same_surface) {
  do_here({"in.ply", "a.ply"});
  do_here({"in.ply", "b.ply", "--ascii"});
  EXPECT_THAT(bytes("b.ply"), StartsWith("ply\nformat ascii 1.0\n"));
  EXPECT_THAT(bytes("b.covmesh.ply"), StartsWith("ply\nformat ascii 1.0\n"));
  EXPECT_EQ(info("a.ply").at("topology"), info("b.ply").at("topology"));
  do_here({"subdivide", "b.covmesh.ply", "c.ply"});
  EXPECT_TRUE(bytes("c.ply") == bytes("a.ply")) << "the text does not give the same numbers back";
}

TEST_F(ChainTest, dump_keeps_levels_and_fronts) {
  write_bytes(folder / "in.ply", ply_of(noisy_sphere(40000, 0.001)));
  do_here({"in.ply", "out.ply", "--dump", "levels"});
  int levels = 0, fronts = 0;
  int components = 0;
  for (const std::string& name : names_in(folder)) {
    if (!name.starts_with("levels/")) continue;
    const json i = info(name);
    if (i.at("kind") == "mixture") {
      ++levels;
      if (components > 0) {
        EXPECT_LT(i.at("components").get<int>(), components);
      }
      components = i.at("components");
      EXPECT_NEAR(i.at("weight").get<double>(), 40000, 1e-6);
    } else {
      ++fronts;
      EXPECT_EQ(i.at("kind"), "mesh");
    }
    // In the coordinates of the input.
    EXPECT_NEAR(i.at("bbox_max")[0].get<double>(), 1, 0.1);
  }
  EXPECT_GE(levels, 3);
  EXPECT_GE(fronts, 1);
}

TEST_F(ChainTest, ellipsoids_of_a_mixture) {
  do_here({"mixture", "in.ply", "m.ply", "--ellipsoids", "e.ply", "--ellipsoid-scale", "0.5"});
  const json mixture = info("m.ply"), ellipsoids = info("e.ply");
  EXPECT_EQ(ellipsoids.at("topology").at("components"), mixture.at("components"));
  EXPECT_EQ(ellipsoids.at("topology").at("boundary_loops"), 0);
  EXPECT_EQ(ellipsoids.at("attributes"), json({"colors"}));
}

TEST_F(ChainTest, log_file_has_everything) {
  do_here({"in.ply", "out.ply", "--quiet", "--log-file", "log.txt"});
  EXPECT_THAT(bytes("log.txt"), HasSubstr("info"));
  const ProcessResult normal = do_here({"in.ply", "out.ply"});
  const ProcessResult verbose = do_here({"in.ply", "out.ply", "--verbose"});
  EXPECT_GE(verbose.err.size(), normal.err.size());
}

TEST_F(ChainTest, compare_two_meshes) {
  do_here({"in.ply", "out.ply"});
  const ProcessResult same = do_here({"compare", "out.ply", "out.ply", "--max-error", "1e-6", "--report", "r.json"});
  EXPECT_THAT(same.out, IsEmpty());
  const json r = report("r.json");
  const json schema = json::parse(read_bytes(GPSRECON_SOURCE_DIR "/docs/reference/report.schema.json"));
  EXPECT_THAT(JsonSchema(schema).errors(r), IsEmpty());
  EXPECT_EQ(r.at("command"), "compare");

  // An octahedron inscribed in the sphere is 1 - 1/√3 away from it in the middle of its faces.
  write_bytes(folder / "octahedron.off",
              "OFF\n6 8 0\n1 0 0\n-1 0 0\n0 1 0\n0 -1 0\n0 0 1\n0 0 -1\n"
              "3 0 2 4\n3 2 1 4\n3 1 3 4\n3 3 0 4\n3 2 0 5\n3 1 2 5\n3 3 1 5\n3 0 3 5\n");
  do_here({"compare", "octahedron.off", "out.ply", "--max-error", "0.46", "--samples", "20000"});
  const ProcessResult exceeded =
      run_here({"compare", "octahedron.off", "out.ply", "--max-error", "0.38", "--samples", "20000", "--quiet"});
  EXPECT_EQ(exceeded.exit_code, 7);
  EXPECT_THAT(exceeded.err, StartsWith("gpsrecon: warning: the largest distance"));
  EXPECT_EQ(run_here({"compare", "out.ply", "octahedron.off", "--max-error", "0.38", "--samples", "20000"}).exit_code,
            7);
}

TEST_F(ChainTest, compare_with_points) {
  do_here({"in.ply", "out.ply"});
  const ProcessResult result = do_here({"compare", "out.ply", "in.ply", "--report", "-"});
  const json r = json::parse(result.out);
  const json schema = json::parse(read_bytes(GPSRECON_SOURCE_DIR "/docs/reference/report.schema.json"));
  EXPECT_THAT(JsonSchema(schema).errors(r), IsEmpty());
  EXPECT_EQ(run_here({"compare", "out.ply", "in.ply", "--max-error", "0.1"}).exit_code, 0);
  EXPECT_EQ(run_here({"compare", "out.ply", "in.ply", "--max-error", "0.0001"}).exit_code, 7);
}

TEST_F(ChainTest, compare_reads_covariance_meshes_and_points_in_either_place) {
  do_here({"in.ply", "out.ply"});
  const auto compared = [&](const std::string& judged, const std::string& reference) {
    return json::parse(do_here({"compare", judged, reference, "--report", "-", "--samples", "20000"}).out);
  };
  const json surface = compared("out.covmesh.ply", "out.ply").at("reference");
  EXPECT_LT(surface.at("mesh_to_reference").at("distance").at("rel").at("rms"), 1e-4);
  const json points = compared("in.ply", "out.ply");
  EXPECT_TRUE(points.at("mesh").is_null());
  EXPECT_EQ(points.at("input").at("file"), "in.ply");
  EXPECT_EQ(points.at("reference").at("file").at("file"), "out.ply");
  EXPECT_EQ(compared("in.ply", "in.ply").at("reference").at("mesh_to_reference").at("distance").at("scene").at("max"),
            0);
  EXPECT_EQ(run_here({"compare", "in.ply", "out.ply", "--html", "page.html"}).exit_code, 2);
  EXPECT_EQ(run_here({"compare", "in.ply", "out.ply", "--self-intersections"}).exit_code, 2);
}

TEST_F(ChainTest, errors_to_look_at) {
  do_here({"in.ply", "out.ply", "--html", "page.html", "--heatmap", "colors.ply"});
  EXPECT_THAT(bytes("page.html"), HasSubstr("points to surface"));
  EXPECT_THAT(bytes("colors.ply"), HasSubstr("property float error"));
  do_here({"compare", "out.ply", "out.ply", "--html", "page.html", "--heatmap", "colors.ply", "--heatmap-max", "0.1"});
  EXPECT_THAT(bytes("page.html"), HasSubstr("F-score"));
  EXPECT_THAT(bytes("colors.ply"), HasSubstr("signed_error"));
  // The page is the same for any number of threads, as all else.
  do_here({"in.ply", "out.ply", "--html", "one.html", "--threads", "1"});
  do_here({"in.ply", "out.ply", "--html", "two.html", "--threads", "3"});
  EXPECT_EQ(bytes("one.html"), bytes("two.html"));
  EXPECT_EQ(run_here({"out.covmesh.ply", "again.ply", "--html", "page.html"}).exit_code, 2);
  EXPECT_EQ(run_here({"in.ply", "out.ply", "--html", "out.ply"}).exit_code, 2);
}

TEST_F(ChainTest, catmull_clark_gives_quadrilaterals) {
  do_here({"in.ply", "out.ply", "--scheme", "catmull-clark"});
  const json r = report("out.report.json");
  EXPECT_EQ(r.at("mesh").at("topology").at("euler"), 2);
  EXPECT_EQ(r.at("mesh").at("faces"), r.at("mesh").at("vertices").get<int>() - 2);  // closed, of quadrilaterals
}

TEST_F(ChainTest, every_command_reads_the_rules_of_the_surface_in_the_file) {
  do_here({"in.ply", "out.ply", "--scheme", "catmull-clark", "--levels", "2"});
  EXPECT_EQ(info("out.covmesh.ply").at("surface"),
            json({{"scheme", "catmull-clark"}, {"loop_weights", "loop"}, {"corners", "smooth"}}));
  // The surface that is compared is that of the file, although its faces are triangles.
  do_here({"compare", "out.covmesh.ply", "out.ply", "--samples", "1000", "--max-error", "1e-6"});
  do_here({"covmesh", "out.covmesh.ply", "loop.ply", "--scheme", "loop"});
  EXPECT_EQ(run_here({"compare", "loop.ply", "out.ply", "--samples", "1000", "--max-error", "1e-6"}).exit_code, 7);
  do_here({"covmesh", "loop.ply", "back.ply", "--scheme", "catmull-clark"});
  EXPECT_TRUE(bytes("back.ply") == bytes("out.covmesh.ply"));
  // What is given on the line takes precedence, and stays with what is written.
  do_here({"subdivide", "loop.ply", "s.ply", "--scheme", "catmull-clark", "--levels", "2"});
  do_here({"loop.ply", "c.ply", "--scheme", "catmull-clark", "--levels", "2"});
  EXPECT_TRUE(bytes("s.ply") == bytes("out.ply"));
  EXPECT_TRUE(bytes("c.ply") == bytes("out.ply"));
  EXPECT_TRUE(bytes("c.covmesh.ply") == bytes("out.covmesh.ply"));
  do_here({"fit", "loop.ply", "in.ply", "f.ply", "--corners", "sharp", "--loop-weights", "warren"});
  EXPECT_EQ(info("f.ply").at("surface"), json({{"scheme", "loop"}, {"loop_weights", "warren"}, {"corners", "sharp"}}));
}

TEST_F(ChainTest, polygons_are_catmull_clarks) {
  write_bytes(folder / "cube.off",
              "OFF\n8 6 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n"
              "4 0 3 2 1\n4 4 5 6 7\n4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n");
  do_here({"infer", "cube.off", "cube.ply"});
  for (const std::vector<std::string>& line :
       std::vector<std::vector<std::string>>{{"subdivide", "cube.ply", "s.ply", "--scheme", "loop"},
                                             {"cube.ply", "s.ply", "--scheme", "loop"},
                                             {"infer", "cube.off", "s.ply", "--scheme", "loop"},
                                             {"covmesh", "cube.ply", "s.ply", "--scheme", "loop"},
                                             {"fit", "cube.ply", "in.ply", "s.ply"}}) {
    const ProcessResult refused = run_here(line);
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_THAT(refused.err, ContainsRegex("cube\\.(ply|off): face 0 has 4 corners"));
  }
  do_here({"subdivide", "cube.ply", "s.ply", "--levels", "2"});
  do_here({"cube.ply", "c.ply", "--levels", "2"});
  EXPECT_EQ(bytes("s.ply"), bytes("c.ply"));
  do_here({"compare", "cube.ply", "s.ply", "--samples", "1000", "--max-error", "1e-6"});
}

TEST_F(ChainTest, infer_repairs_what_it_is_told_to) {
  // Three faces on an edge, one over a corner twice.
  write_bytes(folder / "book.off",
              "OFF\n5 4 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n0 -1 0\n3 0 1 2\n3 1 0 3\n3 0 1 4\n3 0 0 1\n");
  EXPECT_EQ(run_here({"infer", "book.off", "book.ply"}).exit_code, 3);
  const ProcessResult result = do_here({"infer", "book.off", "book.ply", "--repair"});
  EXPECT_THAT(result.err, AllOf(HasSubstr("1 edges of more than two faces cut"), HasSubstr("1 faces dropped")));
  do_here({"subdivide", "book.ply", "s.ply"});
}

TEST_F(ChainTest, covariance_meshes_are_repaired_when_told_to) {
  // Three faces on an edge.
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
      "property double covxx\nproperty double covxy\nproperty double covxz\nproperty double covyy\n"
      "property double covyz\nproperty double covzz\nproperty double weight\nelement face 3\n"
      "property list uchar int vertex_indices\nend_header\n";
  for (const char* position : {"0 0 0", "1 0 0", "0 1 0", "0 0 1", "0 -1 0"})
    text += std::string(position) + " 0.1 0 0 0.1 0 0.1 1\n";
  write_bytes(folder / "book.ply", text + "3 0 1 2\n3 1 0 3\n3 0 1 4\n");
  for (const std::string command : {"subdivide", "covmesh"}) {
    const ProcessResult refused = run_here({command, "book.ply", "out.ply"});
    EXPECT_EQ(refused.exit_code, 3);
    EXPECT_THAT(refused.err, HasSubstr("1 edges of more than two faces (first: 0-1 of face 0)"));
    EXPECT_FALSE(std::filesystem::exists(folder.path() / "out.ply"));
  }
  const ProcessResult result = do_here({"subdivide", "book.ply", "s.ply", "--repair", "--levels", "1"});
  EXPECT_THAT(result.err, HasSubstr("1 edges of more than two faces cut"));
  do_here({"covmesh", "book.ply", "parted.ply", "--repair"});
  do_here({"subdivide", "parted.ply", "p.ply", "--levels", "1"});
  EXPECT_EQ(bytes("s.ply"), bytes("p.ply"));
  // Copies share the weight.
  const CovMesh parted = read_covmesh(folder / "parted.ply");
  EXPECT_EQ(parted.vertices.size(), 9U);
  EXPECT_NEAR(std::accumulate(parted.vertices.weights.begin(), parted.vertices.weights.end(), 0.0), 5, 1e-12);
}

TEST_F(ChainTest, project_writes_particles_with_normals) {
  do_here({"project", "in.ply", "p.ply", "--particles", "50%"});
  EXPECT_THAT(bytes("p.ply"), HasSubstr(" nx\n"));
  do_here({"project", "in.ply", "bare.ply", "--method", "wlop", "--particles", "100", "--no-normals"});
  EXPECT_THAT(bytes("bare.ply"), HasSubstr("element vertex 100\n"));
  EXPECT_THAT(bytes("bare.ply"), Not(HasSubstr(" nx\n")));
  do_here({"in.ply", "a.ply", "--project", "clop"});
  do_here({"in.ply", "b.ply", "--project", "clop", "--threads", "1"});
  EXPECT_EQ(bytes("a.ply"), bytes("b.ply"));
  EXPECT_EQ(run_here({"project", "in.ply", "p.ply", "--particles", "0"}).exit_code, 2);
  EXPECT_EQ(run_here({"project", "in.ply", "p.ply", "--support-radius", "-1"}).exit_code, 2);
  EXPECT_EQ(run_here({"in.ply", "a.ply", "--project", "clap"}).exit_code, 2);
}

}  // namespace
}  // namespace gpsrecon::test
