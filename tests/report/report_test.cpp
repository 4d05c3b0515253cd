#include <gmock/gmock.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/report/report.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>

#include "support/json_schema.h"
#include "support/meshes.h"

namespace gpsrecon::test {

using namespace internal;
namespace {

using Json = nlohmann::ordered_json;

nlohmann::json schema_json() {
  std::ifstream file(GPSRECON_SOURCE_DIR "/docs/reference/report.schema.json");
  return nlohmann::json::parse(file);
}

const JsonSchema& schema() {
  static const JsonSchema the_schema(schema_json());
  return the_schema;
}

testing::AssertionResult valid(const std::string& text) {
  const auto errors = schema().errors(nlohmann::json::parse(text));
  if (errors.empty()) return testing::AssertionSuccess();
  testing::AssertionResult result = testing::AssertionFailure();
  for (const std::string& error : errors) result << error << "\n";
  return result;
}

/// Every part present.
ErrorReport full_report() {
  const Mesh mesh = quad_torus(30, 20, 1.5, 0.5);
  PointCloud cloud;
  Random random(61);
  for (int i = 0; i < 500; ++i) cloud.positions.push_back(random.vector(-2, 2));
  ErrorReport report = report_of(compare(mesh, cloud));
  CompareOptions options;
  options.samples = 500;
  report.reference = report_of(compare(mesh, sphere(3), options)).reference;
  report.reference->file = FileReport{"truth.ply", "ply", "0123456789abcdef"};
  report.alignment = Alignment{Mat3::Identity(), Vec3(1, 2, 3), 7, true, 0.2, 0.1};
  report.version = "1.2.3";
  report.command = "reconstruct";
  report.input->file = {"scan.ply", "ply", ""};
  report.input->points = 520;
  report.dropped = {{"non_finite", 3}, {"duplicate", 10}, {"isolated", 7}};
  report.scale = ScaleReport{{0.1, 0.03, 0.11, "spacing and noise"}, {}, {}};
  report.scale->search = ScaleSearchReport{"max_error", 0.01, {{1, 0.1, 60, 62, 0.02}, {0.5, 0.2, 30, 31, 0.04}}, 1};
  report.scale->check = ScaleCheckReport{100, {{1, 0.1, 50, -3.5}, {2, 0.2, 20, -4}}, 1};
  report.mixture = MixtureStatistics{{500, 170, 60}, 60, 517};
  CovMeshReport covmesh;
  covmesh.vertices = 58;
  covmesh.faces = 110;
  covmesh.topology = topology(square(0).faces, 4);
  covmesh.light_components = 4;
  covmesh.light_weight = 4.5;
  covmesh.leftover_components = 2;
  covmesh.leftover_weight = 3.25;
  covmesh.self_intersecting_faces = 4;
  covmesh.boundary_loops = measure_boundary_loops(square(0).positions, build_connectivity(square(0).faces, 4), {});
  report.covmesh = covmesh;
  report.fit = FitStatistics{7, 2, 31, 4, 0.01, 0.1, 120, 0.05, 0.03};
  report.mesh->level = 2;
  report.mesh->file = FileReport{"mesh.ply", "ply", "0123456789abcdef"};
  report.compression = Compression{1560, 910, 910.0 / 1560};
  report.warnings = {"something to know"};
  report.options = {{"detail", 1.0}, {"holes", std::string("auto")}, {"levels", std::int64_t{2}}, {"fit", true}};
  report.seed = std::numeric_limits<std::int64_t>::max();  // valijson takes larger ones for negative
  report.versions = library_versions();
  report.run = {2, {{"read", 0.1, 0.1}, {"mixture", 1.5, 2.9}}, 1.7, 3.1, std::uint64_t{5} << 30};
  return report;
}

/// Calls visit(pointer, value) for everything inside `json`.
template <class Visit>
void for_each(const nlohmann::json& json, const nlohmann::json::json_pointer& at, const Visit& visit) {
  if (json.is_object())
    for (const auto& [key, value] : json.items()) {
      visit(at / key, value);
      for_each(value, at / key, visit);
    }
  if (json.is_array())
    for (std::size_t i = 0; i < json.size(); ++i) {
      visit(at / i, json[i]);
      for_each(json[i], at / i, visit);
    }
}

TEST(ReportSchema, AcceptsEveryReport) {
  EXPECT_TRUE(valid(to_json(full_report())));
  EXPECT_TRUE(valid(to_json(ErrorReport{})));
  const Mesh mesh = sphere(2);
  CompareOptions options;
  options.samples = 100;
  EXPECT_TRUE(valid(to_json(report_of(compare(mesh, mesh, options)))));
  EXPECT_TRUE(valid(to_json(report_of(compare(square(0), mesh, options)))));
  PointCloud point;
  point.positions = {Vec3::Zero()};
  EXPECT_TRUE(valid(to_json(report_of(compare(mesh, point)))));
}

TEST(ReportSchema, MissesEveryKey) {
  const nlohmann::json report = nlohmann::json::parse(to_json(full_report()));
  int removed = 0;
  for_each(report, nlohmann::json::json_pointer(), [&](const nlohmann::json::json_pointer& at, const auto&) {
    const nlohmann::json& parent = report.at(at.parent_pointer());
    const std::string where = at.to_string();
    if (!parent.is_object() || where.rfind("/options/", 0) == 0 || where.rfind("/versions/", 0) == 0) return;
    nlohmann::json broken = report;
    broken.at(at.parent_pointer()).erase(at.back());
    EXPECT_FALSE(schema().errors(broken).empty()) << "without " << where;
    ++removed;
  });
  EXPECT_GT(removed, 150);
}

TEST(ReportSchema, NoticesEveryChangedType) {
  const nlohmann::json report = nlohmann::json::parse(to_json(full_report()));
  for_each(report, nlohmann::json::json_pointer(), [&](const nlohmann::json::json_pointer& at, const auto& value) {
    std::vector<nlohmann::json> wrong{nlohmann::json::array({nullptr})};
    const bool is_option = at.to_string().rfind("/options/", 0) == 0;
    if (!is_option) wrong.push_back(value.is_string() ? nlohmann::json(1) : nlohmann::json("text"));
    if (!is_option) wrong.push_back(value.is_boolean() ? nlohmann::json(1) : nlohmann::json(true));
    for (const nlohmann::json& other : wrong) {
      nlohmann::json broken = report;
      broken.at(at) = other;
      EXPECT_FALSE(schema().errors(broken).empty()) << at.to_string() << " = " << other;
    }
    if (value.is_number()) {
      const std::string where = at.to_string();
      const bool may_be_negative =
          is_option || where.find("/center/") != std::string::npos || where.find("/max_at/") != std::string::npos ||
          where.find("/volume") != std::string::npos || where.find("/mean_log_likelihood") != std::string::npos ||
          where.find("/euler") != std::string::npos || where.find("/genus") != std::string::npos ||
          where.find("/signed_mean/") != std::string::npos || where.find("/rotation/") != std::string::npos ||
          where.find("/translation/") != std::string::npos;
      nlohmann::json broken = report;
      broken.at(at) = -1;
      EXPECT_EQ(schema().errors(broken).empty(), may_be_negative) << where << " = -1";
    }
  });
}

TEST(ReportSchema, NoticesUnknownKeys) {
  const nlohmann::json report = nlohmann::json::parse(to_json(full_report()));
  std::vector<nlohmann::json::json_pointer> objects{nlohmann::json::json_pointer()};
  for_each(report, nlohmann::json::json_pointer(), [&](const nlohmann::json::json_pointer& at, const auto& value) {
    if (value.is_object() && at.to_string() != "/options" && at.to_string() != "/versions") objects.push_back(at);
  });
  for (const auto& at : objects) {
    nlohmann::json broken = report;
    broken.at(at)["surprise"] = 1;
    EXPECT_FALSE(schema().errors(broken).empty()) << at.to_string();
  }
}

TEST(ReportSchema, KnowsItsVersion) {
  nlohmann::json report = nlohmann::json::parse(to_json(full_report()));
  report["schema"] = "gpsrecon.report/2";
  EXPECT_FALSE(schema().errors(report).empty());
}

/// Every keyword that the schema of the report uses, with documents that it refuses.
TEST(JsonSchemaCheck, RefusesWrongDocuments) {
  const JsonSchema schema(nlohmann::json::parse(R"({
    "type": "object",
    "properties": {
      "const": {"const": "a"}, "enum": {"enum": [1, "x"]}, "pattern": {"type": "string", "pattern": "^[0-9a-f]{2}$"},
      "range": {"type": "number", "minimum": 0, "maximum": 1}, "count": {"type": "integer"},
      "list": {"type": "array", "items": {"type": "boolean"}, "minItems": 1, "maxItems": 2},
      "one": {"oneOf": [{"$ref": "#/$defs/part"}, {"type": "null"}]},
      "map": {"type": "object", "additionalProperties": {"type": ["number", "string"]}}
    },
    "required": ["count"], "additionalProperties": false,
    "$defs": {"part": {"type": "object", "properties": {"a": {"type": "number"}}, "required": ["a"]}}
  })"));
  const nlohmann::json right = nlohmann::json::parse(
      R"({"const": "a", "enum": "x", "pattern": "0f", "range": 1, "count": -3, "list": [true, false], "one": {"a": 0.5},
          "map": {"b": 1, "c": "d"}})");
  EXPECT_THAT(schema.errors(right), testing::IsEmpty());
  EXPECT_THAT(schema.errors({{"count", 3}, {"one", nullptr}}), testing::IsEmpty());
  for (const char* const wrong :
       {R"({})", R"([])", R"({"count": 1, "surprise": 1})", R"({"count": 1.5})", R"({"count": true})",
        R"({"count": "1"})", R"({"count": null})", R"({"count": 1, "const": "b"})", R"({"count": 1, "enum": 2})",
        R"({"count": 1, "pattern": "0f0"})", R"({"count": 1, "range": -0.1})", R"({"count": 1, "range": 1.1})",
        R"({"count": 1, "list": []})", R"({"count": 1, "list": [true, true, true]})", R"({"count": 1, "list": [1]})",
        R"({"count": 1, "one": {}})", R"({"count": 1, "one": {"a": "b"}})", R"({"count": 1, "map": {"b": true}})"})
    EXPECT_THAT(schema.errors(nlohmann::json::parse(wrong)), testing::Not(testing::IsEmpty())) << wrong;
}

TEST(ReportJson, KeepsTheOrderOfTheSchema) {
  std::ifstream file(GPSRECON_SOURCE_DIR "/docs/reference/report.schema.json");
  const Json ordered_schema = Json::parse(file);
  const auto keys = [](const Json& object) {
    std::vector<std::string> names;
    for (const auto& [key, value] : object.items()) names.push_back(key);
    return names;
  };
  const Json report = Json::parse(to_json(full_report()));
  EXPECT_EQ(keys(report), keys(ordered_schema["properties"]));
  for (const std::string part :
       {"input", "scale", "mixture", "covmesh", "fit", "mesh", "reference", "compression", "run"})
    EXPECT_EQ(keys(report[part]), keys(ordered_schema["$defs"][part]["properties"])) << part;
  EXPECT_EQ(to_json(full_report()), to_json(full_report()));
}

TEST(ReportJson, NumbersReadBackToTheSameBits) {
  ErrorReport report = full_report();
  for (const double x : {0.1, 1.0 / 3, 5e-324, 1.7976931348623157e308, 123456789.123456789, 3.0}) {
    report.scale->spacing = x;
    report.options["x"] = x;
    const Json json = Json::parse(to_json(report));
    EXPECT_EQ(json["scale"]["spacing"]["scene"].get<double>(), x);
    EXPECT_EQ(json["options"]["x"].get<double>(), x);
  }
  report.seed = std::numeric_limits<std::uint64_t>::max();
  const Json json = Json::parse(to_json(report));
  EXPECT_EQ(json["seed"].get<std::uint64_t>(), report.seed);
  EXPECT_EQ(json["run"]["peak_memory_bytes"].get<std::uint64_t>(), report.run.peak_memory_bytes);
  const Statistics& s = report.points_to_surface->distance;
  EXPECT_EQ(json["points_to_surface"]["scene"]["rms"].get<double>(), s.rms);
  EXPECT_NEAR(json["points_to_surface"]["rel"]["rms"].get<double>() * report.diagonal, s.rms, 1e-15);
  EXPECT_EQ(json["points_to_surface"]["max_at"].get<std::vector<double>>(),
            (std::vector<double>{report.points_to_surface->max_at.x(), report.points_to_surface->max_at.y(),
                                 report.points_to_surface->max_at.z()}));
}

TEST(ReportJson, OptionsKeepTheirTypes) {
  const Json json = Json::parse(to_json(full_report()))["options"];
  EXPECT_TRUE(json["detail"].is_number_float());
  EXPECT_TRUE(json["levels"].is_number_integer());
  EXPECT_TRUE(json["holes"].is_string());
  EXPECT_TRUE(json["fit"].is_boolean());
}

TEST(ReportJson, RunHoldsAllThatDiffersBetweenRuns) {
  ErrorReport a = full_report(), b = full_report();
  b.run = {7, {{"read", 3, 4}}, 5, 6, 8};
  Json x = Json::parse(to_json(a)), y = Json::parse(to_json(b));
  EXPECT_NE(x, y);
  x.erase("run");
  y.erase("run");
  EXPECT_EQ(x.dump(), y.dump());
}

TEST(ReportJson, RefusesNumbersThatAreNotFinite) {
  ErrorReport report = full_report();
  report.covmesh->boundary_loops[0].center.y() = std::nan("");
  try {
    to_json(report);
    FAIL() << "accepted";
  } catch (const InvariantError& e) {
    EXPECT_NE(std::string(e.what()).find("covmesh.boundary_loops[0].center[1]"), std::string::npos) << e.what();
  }
  report = full_report();
  report.options["x"] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(to_json(report), InvariantError);
}

TEST(ReportJson, SurvivesNamesThatAreNotText) {
  ErrorReport report = full_report();
  report.input->file.file = "scan\xff\xfe \"quoted\" \n.ply";
  EXPECT_TRUE(valid(to_json(report)));
}

TEST(ReportSummary, SaysWhatCountsInAboutTenLines) {
  ErrorReport report = full_report();
  const std::string text = summary(report);
  const auto lines = std::count(text.begin(), text.end(), '\n');
  EXPECT_GE(lines, 8);
  EXPECT_LE(lines, 14);
  for (const char* part :
       {"520 points", "scan.ply", "10 duplicate", "60 Gaussians", "2 levels", "genus 1", "RMS", "thread"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  EXPECT_EQ(text.find("NOT MANIFOLD"), std::string::npos);
  report.mesh->topology.nonmanifold_edges = 1;
  EXPECT_NE(summary(report).find("NOT MANIFOLD"), std::string::npos);
}

TEST(ReportSummary, NamesTheBlindSpotOfSelfConsistency) {
  ErrorReport report = full_report();
  report.reference.reset();
  EXPECT_NE(summary(report).find("not accuracy"), std::string::npos);
  EXPECT_EQ(summary(ErrorReport{}).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace gpsrecon::test
