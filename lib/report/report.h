#pragma once

#include <gpsrecon/core/options.h>
#include <gpsrecon/core/resource_usage.h>
#include <gpsrecon/core/run_context.h>
#include <gpsrecon/fit/fit.h>
#include <gpsrecon/hem/hem.h>
#include <gpsrecon/measure/align.h>
#include <gpsrecon/measure/compare.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/triangulate/triangulate.h>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <variant>
#include <vector>

// What a run has to say about itself, as plain data. Lengths are in scene units (those of the input file),
// positions in world coordinates; a length over the diagonal D of the report is called relative. Optional parts are
// absent where they do not apply: a comparison of two meshes has no mixture, a reconstruction without truth no
// reference.

namespace gpsrecon {

/// A file that was read.
struct FileReport {
  std::string file;    ///< as the caller named it
  std::string format;  ///< "ply", "xyz", ...
  std::string hash;    ///< hash_file(), 16 hexadecimal digits; empty if unknown (standard input)
};

/// The points that were read.
struct InputReport {
  FileReport file;
  std::size_t points = 0;  ///< rows read, dropped ones included
  double diagonal = 0;     ///< D: of the points kept, after duplicates, isolated and non-finite ones are gone
};

/// Points that were read but not used.
struct DroppedPoints {
  std::string reason;  ///< "non_finite", "duplicate" (merged into one point of higher weight), "isolated", ...
  std::size_t points = 0;
};

/// A kernel that was tried in the search for the right one.
struct ScaleTrial {
  double detail = 1;  ///< divides the automatic kernel width
  double sigma0 = 0;
  std::size_t components = 0;           ///< of the mixture
  std::optional<std::size_t> vertices;  ///< of the covariance mesh, if one was made
  std::optional<double> error;          ///< bound of the root mean square offset of the surface, if it was measured
};

/// How a budget or an error bound led to the kernel.
struct ScaleSearchReport {
  std::string by;     ///< "budget" or "max_error"
  double wanted = 0;  ///< vertices, or error as a share of the diagonal
  std::vector<ScaleTrial> tried;
  std::size_t chosen = 0;  ///< index into `tried`
};

/// How likely points that were held out are under the mixture of the others, for one kernel.
struct KernelLikelihood {
  double factor = 1;  ///< times the automatic width
  double sigma0 = 0;
  std::size_t components = 0;
  double mean_log_likelihood = 0;  ///< per point, of densities per D³
};

struct ScaleCheckReport {
  std::size_t held_out_points = 0;
  std::vector<KernelLikelihood> tried;
  double best = 1;  ///< factor with the largest likelihood
};

/// The kernel, and how its width was searched for or checked.
struct ScaleReport : KernelStatistics {
  std::optional<ScaleSearchReport> search = std::nullopt;  ///< if there was one
  std::optional<ScaleCheckReport> check = std::nullopt;    ///< if it was asked for
};

/// The covariance mesh as it is, and how it came about.
struct CovMeshReport : TriangulationStatistics {
  std::size_t vertices = 0, faces = 0;
  Topology topology = {};
  std::optional<std::size_t> self_intersecting_faces = std::nullopt;  ///< if they were counted
  std::vector<BoundaryLoop> boundary_loops = {};
};

/// The mesh, and where it comes from.
struct MeshReport : MeshMeasures {
  std::optional<FileReport> file = std::nullopt;  ///< if it was read
  std::optional<int> level = std::nullopt;        ///< subdivision level, if it was made here
};

/// The comparison with a reference, and which file that was.
struct ReferenceReport : ReferenceMeasures {
  std::optional<FileReport> file = std::nullopt;
};

/// What depends on the machine and the moment. Nothing else in a report differs between runs.
struct RunReport {
  int threads = 1;
  std::vector<StageTime> stages;
  double wall_s = 0, cpu_s = 0;
  std::uint64_t peak_memory_bytes = 0;
};

struct ErrorReport {
  std::string version;  ///< of the program
  std::string command;  ///< "reconstruct", "compare", ...
  double diagonal = 0;  ///< D; 0 if all points coincide, then nothing relative is reported
  std::optional<InputReport> input;
  std::vector<DroppedPoints> dropped;
  std::optional<ScaleReport> scale;
  std::optional<MixtureStatistics> mixture;
  std::optional<CovMeshReport> covmesh;
  std::optional<FitStatistics> fit;
  std::optional<MeshReport> mesh;
  std::optional<DistanceMeasures> points_to_surface;
  std::optional<DirectionMeasures> surface_to_points;  ///< samples of the surface to the nearest point
  std::optional<Thresholds> thresholds;                ///< of that
  std::optional<ReferenceReport> reference;
  std::optional<Alignment> alignment;  ///< if it was asked for
  std::optional<Compression> compression;
  std::vector<std::string> warnings;
  std::map<std::string, OptionValue> options;  ///< in force, by name
  std::uint64_t seed = 1;
  std::map<std::string, std::string> versions;  ///< of libraries and compiler, see library_versions()
  RunReport run;
};

/// The report as JSON, schema gpsrecon.report/1 (docs/reference/report.schema.json): every key always present, in
/// fixed order, null where a part does not apply; numbers read back to the same bits. Throws InvariantError, naming
/// the key, if a number is not finite.
std::string to_json(const ErrorReport& report);

/// What the run context knows: seed, threads, warnings and times so far (RunContext::record), and the versions.
void note_run(ErrorReport& report, const RunContext& context);

/// The report of a comparison: what was measured, and the counts of what it was measured from.
ErrorReport report_of(const Comparison& comparison);

/// About ten lines for people, ending in a newline.
std::string summary(const ErrorReport& report);

/// Versions of what this library was compiled with.
std::map<std::string, std::string> library_versions();

}  // namespace gpsrecon
