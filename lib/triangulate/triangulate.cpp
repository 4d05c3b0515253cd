// Preiner et al. 2019, section 6.2. What the greedy front leaves open is closed by the steps after it.

#include <gpsrecon/triangulate/triangulate.h>

#include <gpsrecon/core/error.h>
#include <gpsrecon/core/mesh_topology.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/core/orient.h>
#include <gpsrecon/triangulate/flips.h>
#include <gpsrecon/triangulate/front.h>
#include <gpsrecon/triangulate/holes.h>
#include <gpsrecon/triangulate/inside_out.h>
#include <gpsrecon/triangulate/light_components.h>
#include <gpsrecon/triangulate/outer_sides.h>
#include <gpsrecon/triangulate/overlap_graph.h>
#include <gpsrecon/triangulate/pieces.h>
#include <gpsrecon/triangulate/pinholes.h>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace gpsrecon {

using namespace internal;
namespace {

/// Keeps the vertices that faces use, in order, and renumbers the corners. Returns the old numbers of those kept.
std::vector<Index> compact(Mixture& vertices, std::vector<Index>& component_of_vertex, FaceList& faces) {
  std::vector<Index> number(vertices.size(), no_index);
  std::vector<Index> kept;
  for (const Index v : faces.corners) number[v] = 0;
  for (Index v = 0; v < vertices.size(); ++v)
    if (number[v] != no_index) {
      number[v] = static_cast<Index>(kept.size());
      kept.push_back(v);
    }
  for (Index& v : faces.corners) v = number[v];
  vertices = select(vertices, kept);
  std::vector<Index> component;
  component.reserve(kept.size());
  for (const Index v : kept) component.push_back(component_of_vertex[v]);
  component_of_vertex = std::move(component);
  return kept;
}

/// Counts the copies of Gaussians, and gives the copies of each all its weight, also where some of them were in regions
/// that were replaced since. Those of `before` that have no vertex any more are left over.
void count_copies(Triangulation& result, const Mixture& mixture, const std::vector<Index>& before) {
  std::vector<std::size_t> copies(mixture.size(), 0);
  for (const Index s : result.component_of_vertex)
    if (s != no_index && ++copies[s] > 1) ++result.split_vertices;
  for (Index v = 0; v < result.mesh.vertices.size(); ++v)
    if (const Index s = result.component_of_vertex[v]; s != no_index)
      result.mesh.vertices.weights[v] = mixture.weights[s] / static_cast<double>(copies[s]);
  for (const Index s : before) {
    if (copies[s] > 0) continue;
    copies[s] = 1;  // once
    ++result.leftover_components;
    result.leftover_weight += mixture.weights[s];
  }
}

}  // namespace

std::string_view name_of(LoopReason reason) {
  switch (reason) {
    case LoopReason::rim:
      return "rim";
    case LoopReason::no_points:
      return "no_points";
    case LoopReason::too_long:
      return "too_long";
    case LoopReason::kept:
      return "kept";
    case LoopReason::no_patch:
      return "no_patch";
    case LoopReason::would_intersect:
      return "would_intersect";
  }
  return "";
}

HoleRule HoleRule::fill(const Length& longest) {
  HoleRule rule(HolePolicy::fill);
  rule.longest = longest;
  return rule;
}

HoleRule HoleRule::parse(const std::string& text) {
  if (text == "auto") return HolePolicy::automatic;
  if (text == "keep") return HolePolicy::keep;
  if (text == "all") return HolePolicy::all;
  constexpr std::string_view prefix = "fill:";
  if (!text.starts_with(prefix)) throw_expected("auto, keep, fill:LENGTH or all", text);
  return fill(Length::parse(text.substr(prefix.size())));
}

std::string HoleRule::text() const {
  switch (policy) {
    case HolePolicy::automatic:
      return "auto";
    case HolePolicy::keep:
      return "keep";
    case HolePolicy::fill:
      return "fill:" + longest.text();
    case HolePolicy::all:
      return "all";
  }
  return "";
}

void TriangulateOptions::check() const {
  check_fields(*this);
  if (holes.policy == HolePolicy::fill && !(holes.longest.number() >= 0 && std::isfinite(holes.longest.number())))
    throw OptionError("holes: the length must be >= 0, not " + holes.longest.text());
  if (holes.policy == HolePolicy::fill && holes.longest.is_automatic())
    throw OptionError("holes: fill needs a length, as in fill:2%");
}

Triangulation triangulate(const Mixture& mixture, const TriangulateOptions& options, const RunContext& context) {
  options.check();
  OverlapGraph graph = overlap_graph(mixture, options.min_overlap, context);
  const std::vector<Index> light = light_components(mixture, graph, options.min_weight_share);
  if (!light.empty()) graph = without(graph, light);
  context.progress("triangulate", 0.1);
  Sheets sheets(sheet_normals(mixture, context));
  sheets.outer = outer_normals(mixture, graph, sheets.normals, context);
  graph = without_opposed(graph, sheets.outer);
  GrowingSurface surface(mixture.means);
  grow_front(surface, graph, sheets, options, context);

  Triangulation result;
  GrowingSurface mended = surface;
  if (const std::size_t turned = turn_inside_out(mended, graph, sheets.normals); turned > 0) {
    grow_front(mended, graph, sheets, options, context);
    if (mended.front_edges() < surface.front_edges()) {
      result.turned_triangles = turned;
      surface = std::move(mended);
    }
  }
  result.light_components = light.size();
  for (const Index i : light) result.light_weight += mixture.weights[i];
  result.closed_pinholes = close_pinholes(surface, mixture, graph, sheets, options);
  result.flipped_edges = flip_edges(surface, graph, options);
  CovMesh& mesh = result.mesh;
  mesh.rules = options.rules;
  mesh.faces = surface.faces();
  if (mesh.faces.empty())
    throw NoSurfaceError("no three of the " + std::to_string(mixture.size()) +
                         " Gaussians overlap enough for a triangle");

  for (Index v = 0; v < mixture.size(); ++v)
    if (!surface.used(v) && !std::binary_search(light.begin(), light.end(), v)) {
      ++result.leftover_components;
      result.leftover_weight += mixture.weights[v];
    }
  Connectivity connectivity = build_connectivity(mesh.faces, mixture.size());
  const DroppedComponents dropped =
      drop_small_components(mixture, graph, mesh.faces, connectivity, options.min_component_share);
  result.dropped_components = dropped.count;
  result.dropped_component_weight = dropped.weight;

  mesh.vertices = mixture;
  result.component_of_vertex.resize(mixture.size());
  for (Index v = 0; v < mixture.size(); ++v) result.component_of_vertex[v] = v;
  split_vertices(mesh.vertices, result.component_of_vertex, mesh.faces, connectivity);
  compact(mesh.vertices, result.component_of_vertex, mesh.faces);
  connectivity = over_vertices(std::move(connectivity), mesh.faces.corners, mesh.vertices.size());
  const std::vector<Index> before = result.component_of_vertex;
  const Mending mending = mend(mesh, connectivity, result.component_of_vertex, mixture, options, context);
  result.untangled = mending.untangled;
  result.removed_handles = mending.handles;
  result.filled_holes = mending.filled;
  result.filled_rims = mending.rims;
  result.filled_vertices = mending.new_vertices;
  if (mending.rims > 0)
    context.warn(std::to_string(mending.rims) + " outer rims of open sheets were capped: there are no points there");
  const std::vector<Index> kept = compact(mesh.vertices, result.component_of_vertex, mesh.faces);
  count_copies(result, mixture, before);
  std::optional<Vec3> sensor;
  if (options.sensor) sensor = mixture.frame.to_local(*options.sensor);
  result.connectivity = build_connectivity(mesh.faces, mesh.vertices.size());
  result.flipped_components = orient(mesh.vertices, mesh.faces, result.connectivity, sensor);
  if (!mesh.vertices.outward.empty())
    result.flipped_components += orient_outward(mesh.vertices, mesh.faces, result.connectivity);
  for (const std::vector<Index>& loop : boundary_loops(result.connectivity))
    result.loop_reasons.push_back(mending.reason[kept[loop.front()]]);
  mesh.vertices = as_stored(mesh.vertices);
  context.log(LogLevel::info, "triangulate: " + std::to_string(mesh.faces.size()) + " faces over " +
                                  std::to_string(mesh.vertices.size()) + " Gaussians, " +
                                  std::to_string(result.loop_reasons.size()) + " boundary loops");
  context.progress("triangulate", 1);
  return result;
}

}  // namespace gpsrecon
