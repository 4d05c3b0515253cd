#include "bind_options.h"

namespace gpsrecon::cli {

void bind_points(Arguments& arguments, ScaleOptions& scale, AttributeOptions* attributes) {
  arguments.group("Points");
  arguments.fields(scale);
  if (attributes != nullptr) arguments.fields(*attributes);
}

void bind_mixture(Arguments& arguments, HemOptions& options) {
  arguments.group("Mixture");
  arguments.fields(options, {"normals"});
}

void bind_chain_projection(Arguments& arguments, ReconstructOptions& options) {
  arguments.group("Projection");
  arguments.option("--project", OptionType<ProjectionMethod>::placeholder(),
                   "make the mixture of particles projected to local medians of the points (gpsrecon project), not of "
                   "the points",
                   "", "none", [&options](const std::string& text) {
                     if (!options.projection) options.projection.emplace();
                     options.projection->method = OptionType<ProjectionMethod>::read(text);
                   });
}

void GivenRules::bind(Arguments& arguments, const SurfaceRules& defaults) {
  bind(arguments, &defaults);
}

void GivenRules::bind(Arguments& arguments) {
  bind(arguments, nullptr);
}

void GivenRules::bind(Arguments& arguments, const SurfaceRules* defaults) {
  arguments.group("Surface");
  const auto otherwise = [&](const auto& rule) -> std::string_view {
    return defaults == nullptr ? "that of the input"
                               : option_names(defaults->*rule)[static_cast<std::size_t>(defaults->*rule)];
  };
  arguments.field(field<&GivenRules::scheme>("scheme", "",
                                             "refinement scheme: triangles to triangles, or polygons to quadrilaterals")
                      .or_else(otherwise(&SurfaceRules::scheme)),
                  this);
  arguments.field(
      field<&GivenRules::corners>("corners", "",
                                  "boundary vertices of a single face: rounded like the rest of the boundary, or kept")
          .or_else(otherwise(&SurfaceRules::corners)),
      this);
  arguments.field(field<&GivenRules::weights>("loop-weights", "",
                                              "weights of interior vertices: Loop's own, or Warren's simpler ones")
                      .or_else(otherwise(&SurfaceRules::weights)),
                  this);
}

SurfaceRules GivenRules::over(const SurfaceRules& rules) const {
  return {.scheme = scheme.value_or(rules.scheme),
          .weights = weights.value_or(rules.weights),
          .corners = corners.value_or(rules.corners)};
}

CovMesh GivenRules::over(CovMesh mesh, const std::string& path) const {
  mesh.rules = over(mesh.rules);
  if (mesh.rules.scheme == Scheme::loop)
    require_triangles(mesh, path, "Loop's scheme refines triangles, --scheme catmull-clark any polygons");
  return mesh;
}

void bind_encoding(Arguments& arguments, PlyEncoding& encoding) {
  arguments.group("Output", false);
  arguments.flag("--ascii", "write PLY files as text instead of binary",
                 [&encoding] { encoding = PlyEncoding::ascii; });
}

}  // namespace gpsrecon::cli
