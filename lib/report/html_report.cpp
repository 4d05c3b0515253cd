#include <gpsrecon/report/html_report.h>

#include <gpsrecon/core/bounding_box.h>
#include <gpsrecon/core/error.h>
#include <gpsrecon/core/face_geometry.h>
#include <gpsrecon/core/numbers.h>
#include <gpsrecon/measure/mesh_measures.h>
#include <gpsrecon/report/html_resources.h>
#include <gpsrecon/report/picture.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <numeric>

namespace gpsrecon {

using namespace internal;
namespace {

/// Colours of the 3-D view: classes of error, and one more for vertices without.
constexpr std::size_t classes = 255;

std::string percent(double share, int digits = 3) {
  return number(100 * share, digits) + "&nbsp;%";
}

std::string count(std::size_t n) {
  std::string digits = std::to_string(n);
  for (std::size_t at = digits.size(); at > 3;) digits.insert(at -= 3, ",");
  return digits;
}

std::string position_text(const Vec3& p) {
  return "(" + number(p.x(), 7) + ", " + number(p.y(), 7) + ", " + number(p.z(), 7) + ")";
}

/// In scene units and, where there is one, as a share of the diagonal.
std::string length(double value, double diagonal) {
  return number(value) + (diagonal > 0 ? " <span class=\"note\">(" + percent(value / diagonal, 4) + ")</span>" : "");
}

std::string hex(const Color& c) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", static_cast<unsigned>(c[0]), static_cast<unsigned>(c[1]),
                static_cast<unsigned>(c[2]));
  return text;
}

std::string row(const std::vector<std::string>& cells, const std::string& tag = "td") {
  std::string html = "<tr>";
  for (std::size_t k = 0; k < cells.size(); ++k)
    html += "<" + tag + (k > 0 ? " class=\"n\">" : ">") + cells[k] + "</" + tag + ">";
  return html + "</tr>\n";
}

/// A set of distances with the name it has on the page.
struct Series {
  std::string name, meaning;
  const DistanceMeasures* report;
  const DirectionMeasures* direction;  ///< null if only distances are known
};

std::vector<Series> series_of(const ErrorReport& r) {
  std::vector<Series> all;
  if (r.points_to_surface)
    all.push_back({"points to surface", "how well the surface explains the points", &*r.points_to_surface, nullptr});
  if (r.surface_to_points)
    all.push_back({"surface to points", "how far the surface is from any point", &r.surface_to_points->distance,
                   &*r.surface_to_points});
  if (r.reference) {
    all.push_back({"result to reference", "how accurate the result is", &r.reference->mesh_to_reference.distance,
                   &r.reference->mesh_to_reference});
    all.push_back({"reference to result", "how complete it is", &r.reference->reference_to_mesh.distance,
                   &r.reference->reference_to_mesh});
  }
  return all;
}

std::string headline(const ErrorReport& r) {
  std::string html = "<div class=\"facts\">";
  const auto fact = [&](const std::string& value, const std::string& what) {
    html += "<div class=\"fact\"><b>" + value + "</b>" + what + "</div>\n";
  };
  for (const Series& s : series_of(r)) fact(length(s.report->distance.rms, r.diagonal), "RMS, " + s.name);
  if (r.reference) fact(number(r.reference->f_score()), "F-score");
  if (r.mesh) {
    fact(count(r.mesh->vertices), "vertices");
    const Topology& t = r.mesh->topology;
    fact(count(t.components), t.components == 1 ? "component" : "components");
    fact(is_closed(t) ? "closed" : count(t.boundary_loops), is_closed(t)            ? "surface"
                                                            : t.boundary_loops == 1 ? "boundary loop"
                                                                                    : "boundary loops");
  }
  if (r.covmesh) fact(count(r.covmesh->vertices), "Gaussians in the covariance mesh");
  return html + "</div>\n";
}

std::string distance_table(const ErrorReport& r) {
  std::string html =
      "<table id=\"distances\">" + row({"", "RMS", "mean", "median", "95 %", "99 %", "max", "at", "samples"}, "th");
  for (const Series& s : series_of(r)) {
    const Statistics& d = s.report->distance;
    const auto at = [&](double value) { return length(value, r.diagonal); };
    html += row({s.name + "<br><span class=\"note\">" + s.meaning + "</span>", at(d.rms), at(d.mean), at(d.median),
                 at(d.p95), at(d.p99), at(d.max), position_text(s.report->max_at), count(d.count)});
  }
  html += "</table>\n<p class=\"note\">Percentages are of the diagonal D = " + number(r.diagonal, 7) + ".</p>\n";
  return html;
}

std::string direction_table(const ErrorReport& r) {
  std::string rows;
  const Thresholds* thresholds = r.reference ? &r.reference->thresholds : r.thresholds ? &*r.thresholds : nullptr;
  if (thresholds == nullptr) return "";
  for (const Series& s : series_of(r)) {
    if (s.direction == nullptr) continue;
    const DirectionMeasures& d = *s.direction;
    rows += row({s.name, percent(d.within, 5), percent(d.far, 4), d.far_area ? number(*d.far_area) : "&ndash;",
                 d.signed_mean ? length(*d.signed_mean, r.diagonal) : "&ndash;",
                 d.normals.count > 0 ? number(d.normals.mean, 3) + "&deg;" : "&ndash;",
                 d.normals.count > 0 ? number(d.normals.p95, 3) + "&deg;" : "&ndash;",
                 d.normals.count > 0 ? percent(d.normals.flipped) : "&ndash;"});
  }
  return "<table id=\"coverage\">" +
         row({"", "within " + percent(thresholds->fscore_rel), "beyond " + percent(thresholds->far_rel), "area beyond",
              "signed mean", "normals, mean", "95 %", "flipped"},
             "th") +
         rows + "</table>\n";
}

// Diagrams over the limits of the histogram, 1-2-5 per decade of the distance relative to D.

constexpr std::array<const char*, 4> line_colors{"#31688e", "#d95f02", "#1b9e77", "#7570b3"};

struct Chart {
  double width = 520, height = 230, left = 52, right = 24, top = 12, bottom = 40;
  std::string body;

  double x(double share) const { return left + share * (width - left - right); }
  double y(double share) const { return height - bottom - share * (height - top - bottom); }
  void line(double x0, double y0, double x1, double y1, const char* color) {
    body += "<line x1=\"" + number(x0, 5) + "\" y1=\"" + number(y0, 5) + "\" x2=\"" + number(x1, 5) + "\" y2=\"" +
            number(y1, 5) + "\" stroke=\"" + color + "\"/>";
  }
  void text(double at_x, double at_y, const char* anchor, const std::string& content) {
    body += "<text x=\"" + number(at_x, 5) + "\" y=\"" + number(at_y, 5) + "\" text-anchor=\"" + anchor + "\">" +
            content + "</text>";
  }
  std::string svg(const std::string& label) const {
    return "<svg role=\"img\" aria-label=\"" + label + "\" viewBox=\"0 0 " + number(width) + " " + number(height) +
           "\" width=\"100%\" xmlns=\"http://www.w3.org/2000/svg\">" + body + "</svg>\n";
  }
};

/// Where a limit lies on the logarithmic axis, in [0, 1].
double axis_share(double relative, const std::vector<double>& edges) {
  return (std::log(relative) - std::log(edges.front())) / (std::log(edges.back()) - std::log(edges.front()));
}

void draw_axis(Chart& chart, const std::vector<double>& edges) {
  for (std::size_t k = 0; k < edges.size(); k += 3) {
    const double x = chart.x(axis_share(edges[k], edges));
    chart.line(x, chart.y(0), x, chart.y(1), "#eeeeee");
    chart.text(x, chart.height - chart.bottom + 15, "middle", number(100 * edges[k], 2) + " %");
  }
  chart.text(chart.x(0.5), chart.height - 8, "middle", "distance, in % of the diagonal");
}

std::string histogram_chart(const std::vector<Series>& all) {
  Chart chart;
  std::vector<std::vector<double>> shares;
  double highest = 0;
  for (const Series& s : all) {
    const Histogram& h = *s.report->histogram;
    const double sum = std::accumulate(h.counts.begin(), h.counts.end(), 0.0);
    std::vector<double> share;
    for (const double c : h.counts) share.push_back(sum > 0 ? c / sum : 0);
    highest = std::max(highest, *std::max_element(share.begin(), share.end()));
    shares.push_back(std::move(share));
  }
  const std::vector<double>& edges = all.front().report->histogram->edges;
  draw_axis(chart, edges);
  const double top = std::max(0.05, std::ceil(highest * 20) / 20);
  for (int k = 0; k <= 4; ++k) {
    chart.line(chart.x(0), chart.y(k / 4.0), chart.x(1), chart.y(k / 4.0), "#eeeeee");
    chart.text(chart.left - 6, chart.y(k / 4.0) + 4, "end", number(100 * top * k / 4, 3) + " %");
  }
  for (std::size_t s = 0; s < all.size(); ++s)
    for (std::size_t k = 0; k < shares[s].size(); ++k) {
      // What is below the first limit and above the last is drawn in the bins beside them, half as wide.
      const double from = k == 0 ? -0.02 : axis_share(edges[k - 1], edges);
      const double to = k == edges.size() ? 1.02 : axis_share(edges[k], edges);
      const double slot = (to - from) / static_cast<double>(all.size());
      const double x0 = chart.x(from + slot * static_cast<double>(s)),
                   x1 = chart.x(from + slot * static_cast<double>(s + 1));
      const double y = chart.y(shares[s][k] / top);
      chart.body += "<rect x=\"" + number(x0, 5) + "\" y=\"" + number(y, 5) + "\" width=\"" +
                    number(std::max(0.0, x1 - x0 - 0.5), 4) + "\" height=\"" + number(chart.y(0) - y, 5) +
                    "\" fill=\"" + line_colors[s % 4] + "\"/>";
    }
  return chart.svg("Histogram of the distances");
}

/// Share of the samples that are farther than a distance, both axes logarithmic: tails show.
std::string error_curve(const std::vector<Series>& all) {
  Chart chart;
  const std::vector<double>& edges = all.front().report->histogram->edges;
  draw_axis(chart, edges);
  constexpr double lowest = -5;  // 0.001 %
  for (int decade = 0; decade >= lowest; --decade) {
    const double y = chart.y(1 - decade / lowest);
    chart.line(chart.x(0), y, chart.x(1), y, "#eeeeee");
    chart.text(chart.left - 6, y + 4, "end", number(std::pow(10.0, decade + 2), 3) + " %");
  }
  for (std::size_t s = 0; s < all.size(); ++s) {
    const Histogram& h = *all[s].report->histogram;
    const double sum = std::accumulate(h.counts.begin(), h.counts.end(), 0.0);
    double below = 0;
    std::string points;
    for (std::size_t k = 0; k < edges.size(); ++k) {
      below += h.counts[k];
      const double farther = sum > 0 ? std::max(0.0, sum - below) / sum : 0;
      const double level = farther > 0 ? std::max(std::log10(farther), lowest) : lowest;
      points += number(chart.x(axis_share(edges[k], edges)), 5) + "," + number(chart.y(1 - level / lowest), 5) + " ";
      if (level == lowest) break;
    }
    chart.body += "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"" + std::string(line_colors[s % 4]) +
                  "\" points=\"" + points + "\"/>";
  }
  return chart.svg("Share of the samples farther than a distance");
}

std::string charts(const ErrorReport& r) {
  std::vector<Series> all = series_of(r);
  std::erase_if(all, [](const Series& s) { return !s.report->histogram; });
  if (all.empty()) return "";
  std::string key;
  for (std::size_t s = 0; s < all.size(); ++s)
    key += "<span style=\"color:" + std::string(line_colors[s % 4]) + "\">&#9632;</span> " + all[s].name + " &nbsp; ";
  return "<h2>Distribution of the distances</h2>\n<p class=\"note\">" + key +
         "</p>\n<div class=\"columns\" style=\"grid-template-columns:1fr 1fr\"><div>Share of the samples per range of "
         "distance" +
         histogram_chart(all) + "</div><div>Share of the samples that are farther (both axes logarithmic)" +
         error_curve(all) + "</div></div>\n";
}

std::string topology_rows(const std::string& name, const Topology& t, const std::optional<std::size_t>& crossing) {
  return row({name, count(t.vertices), count(t.faces), count(t.components), std::to_string(t.euler),
              is_closed(t) ? "yes" : "no", count(t.boundary_loops),
              count(t.nonmanifold_edges) + " / " + count(t.nonmanifold_vertices),
              crossing ? count(*crossing) : "not counted"});
}

std::string topology_section(const ErrorReport& r) {
  std::string html = "<h2>Topology</h2>\n<table id=\"topology\">" +
                     row({"", "vertices", "faces", "components", "Euler number", "closed", "boundary loops",
                          "non-manifold edges / vertices", "self-intersecting faces"},
                         "th");
  if (r.mesh) html += topology_rows("mesh", r.mesh->topology, r.mesh->self_intersecting_faces);
  if (r.covmesh) html += topology_rows("covariance mesh", r.covmesh->topology, r.covmesh->self_intersecting_faces);
  html += "</table>\n";
  if (!r.covmesh || r.covmesh->boundary_loops.empty()) return html;
  const std::vector<BoundaryLoop>& loops = r.covmesh->boundary_loops;
  constexpr std::size_t shown = 50;
  html += "<p>Open boundary loops, longest first:</p>\n<table id=\"loops\">" +
          row({"reason", "edges", "length", "around"}, "th");
  for (std::size_t k = 0; k < std::min(shown, loops.size()); ++k)
    html += row({html_escaped(loops[k].reason), count(loops[k].edges), length(loops[k].length, r.diagonal),
                 position_text(loops[k].center)});
  html += "</table>\n";
  if (loops.size() > shown) html += "<p class=\"note\">and " + count(loops.size() - shown) + " more.</p>\n";
  return html;
}

std::string input_section(const ErrorReport& r) {
  std::string rows;
  const auto add = [&](const std::string& name, const std::string& value) { rows += row({name, value}); };
  if (r.input) {
    if (!r.input->file.file.empty()) add("points from", "<code>" + html_escaped(r.input->file.file) + "</code>");
    add("points", count(r.input->points));
  }
  for (const DroppedPoints& d : r.dropped)
    if (d.points > 0) add("dropped, " + html_escaped(d.reason), count(d.points));
  if (r.mesh && r.mesh->file) add("mesh", "<code>" + html_escaped(r.mesh->file->file) + "</code>");
  if (r.reference && r.reference->file) add("reference", "<code>" + html_escaped(r.reference->file->file) + "</code>");
  if (r.scale) {
    add("sample spacing", length(r.scale->spacing, r.diagonal));
    add("noise", length(r.scale->noise, r.diagonal));
    add("kernel", length(r.scale->sigma0, r.diagonal) + " = " + html_escaped(r.scale->choice));
  }
  if (r.mixture) add("Gaussians of the mixture", count(r.mixture->components));
  if (r.covmesh) {
    add("Gaussians left out", count(r.covmesh->light_components + r.covmesh->leftover_components) + ", " +
                                  number(r.covmesh->light_weight + r.covmesh->leftover_weight) + " points");
    add("holes filled", count(r.covmesh->filled_holes));
  }
  if (r.compression && r.compression->ratio > 0) add("numbers stored per number read", number(r.compression->ratio, 3));
  return "<h2>Input and result</h2>\n<table id=\"input\">" + rows + "</table>\n";
}

std::string options_section(const ErrorReport& r) {
  std::string rows;
  for (const auto& [name, value] : r.options) {
    const std::string text = std::visit(
        [](const auto& v) -> std::string {
          using T = std::decay_t<decltype(v)>;
          if constexpr (std::is_same_v<T, bool>)
            return v ? "yes" : "no";
          else if constexpr (std::is_same_v<T, std::string>)
            return v;
          else if constexpr (std::is_same_v<T, double>)
            return number(v, 6);
          else
            return std::to_string(v);
        },
        value);
    rows += row({"<code>" + html_escaped(name) + "</code>", html_escaped(text)});
  }
  rows += row({"<code>seed</code>", std::to_string(r.seed)});
  return "<details><summary>Options in force</summary>\n<table id=\"options\">" + rows + "</table></details>\n";
}

std::string caveats(const ErrorReport& r) {
  std::string html;
  if (r.points_to_surface)
    html +=
        "<p>Closeness to the points it was made from is <b>consistency, not accuracy</b>: it sees neither errors that "
        "the points share, such as bias and registration, nor surface where there are no points. Noise counts as "
        "distance.</p>\n";
  if (r.reference)
    html +=
        "<p>Both directions count: a small error from result to reference says nothing about what is missing, one "
        "from reference to result nothing about what is too much. The figures are those of <b>samples</b>, drawn "
        "uniformly by area with a fixed seed; the largest distance may be larger between them.</p>\n";
  for (const std::string& w : r.warnings) html += "<p class=\"warning\">" + html_escaped(w) + "</p>\n";
  return html;
}

std::string legend(const ErrorMap& map, double diagonal) {
  constexpr std::size_t steps = 64;
  std::string bar;
  const std::vector<Color> colors = palette(map.is_signed, steps);
  for (std::size_t k = 0; k < steps; ++k)
    bar += "<rect x=\"" + std::to_string(k) + "\" y=\"0\" width=\"1.1\" height=\"1\" fill=\"" + hex(colors[k]) + "\"/>";
  const auto end = [&](double value) {
    return number(value, 3) + (diagonal > 0 ? " (" + percent(value / diagonal) + ")" : "");
  };
  return "<div class=\"legend\"><span>" + (map.is_signed ? "inside &le; " + end(-map.range) : std::string("0")) +
         "</span><svg viewBox=\"0 0 64 1\" preserveAspectRatio=\"none\">" + bar + "</svg><span>" +
         (map.is_signed ? "outside &ge; " : "&ge; ") + end(map.range) + "</span></div>\n";
}

// The mesh for the 3-D view.

std::string base64(const std::string& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned long group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// A mesh in triangles with the class of error of every vertex.
struct Shown {
  std::vector<Vec3> positions;
  std::vector<std::size_t> error_class;
  std::vector<std::array<Index, 3>> faces;
};

Shown triangles_of(const Mesh& mesh, const ErrorMap& map) {
  Shown shown;
  shown.positions = mesh.positions;
  for (const double e : map.errors) shown.error_class.push_back(palette_index(map, e, classes));
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for_each_triangle(mesh.faces[f], [&](Index a, Index b, Index c) { shown.faces.push_back({a, b, c}); });
  return shown;
}

/// Merges the vertices of each cell of a grid into the first of them (Rossignac and Borrel 1993).
Shown clustered(const Shown& fine, const Vec3& low, double cell) {
  std::map<std::array<long, 3>, Index> number_of;
  std::vector<Index> merged(fine.positions.size());
  Shown coarse;
  for (Index v = 0; v < merged.size(); ++v) {
    const Vec3 at = (fine.positions[v] - low) / cell;
    const auto [entry, is_new] = number_of.try_emplace({std::lround(at.x()), std::lround(at.y()), std::lround(at.z())},
                                                       static_cast<Index>(coarse.positions.size()));
    merged[v] = entry->second;
    if (!is_new) continue;
    coarse.positions.push_back(fine.positions[v]);
    coarse.error_class.push_back(fine.error_class[v]);
  }
  for (const auto& [a, b, c] : fine.faces)
    if (merged[a] != merged[b] && merged[b] != merged[c] && merged[c] != merged[a])
      coarse.faces.push_back({merged[a], merged[b], merged[c]});
  return coarse;
}

std::string bytes_of(const std::vector<std::uint32_t>& values, int width) {
  std::string bytes;
  bytes.reserve(values.size() * static_cast<std::size_t>(width));
  for (const std::uint32_t value : values)
    for (int k = 0; k < width; ++k) bytes += static_cast<char>(value >> (8 * k) & 0xFF);
  return bytes;
}

/// JSON for viewer.js; no character in it can end the script element it stands in.
std::string view_data(const Shown& shown, const Box3& box, const View& view, const ErrorMap& map) {
  const double longest = std::max(box.diagonal().maxCoeff(), 1e-300);
  std::vector<std::uint32_t> positions, corners, errors;
  for (const Vec3& p : shown.positions)
    for (Eigen::Index k = 0; k < 3; ++k) {
      const double side = box.diagonal()[k];
      positions.push_back(side > 0 ? static_cast<std::uint32_t>(std::lround((p[k] - box.min()[k]) / side * 65535))
                                   : 0U);
    }
  for (const auto& t : shown.faces) corners.insert(corners.end(), t.begin(), t.end());
  for (const std::size_t e : shown.error_class) errors.push_back(static_cast<std::uint32_t>(e));
  const auto triple = [](const Vec3& v) {
    return "[" + number(v.x(), 8) + "," + number(v.y(), 8) + "," + number(v.z(), 8) + "]";
  };
  std::string colors;
  for (const Color& c : palette(map.is_signed, classes)) colors += "\"" + hex(c) + "\",";
  return "{\"box\":" + triple(box.diagonal() / longest) + ",\"view\":" + triple(view.from) +
         ",\"up\":" + triple(view.up) + ",\"palette\":[" + colors + "\"" + hex(no_error_color) +
         "\"],\"positions\":\"" + base64(bytes_of(positions, 2)) + "\",\"faces\":\"" + base64(bytes_of(corners, 4)) +
         "\",\"errors\":\"" + base64(bytes_of(errors, 1)) + "\"}";
}

std::string replaced(std::string_view page, const std::vector<std::pair<std::string_view, std::string_view>>& parts) {
  std::string result;
  for (const auto& [mark, text] : parts) {
    const std::size_t at = page.find(mark);
    result.append(page.substr(0, at));
    result.append(text);
    page.remove_prefix(at + mark.size());
  }
  result.append(page);
  return result;
}

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      case '\'':
        safe += "&#39;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string html_report(const ErrorReport& report, const Mesh& mesh, const ErrorMap& map, const HtmlOptions& options) {
  options.check();
  const Box3 box = mesh.positions.empty() ? Box3(Vec3(Vec3::Zero())) : bounding_box(mesh.positions);
  const View view = good_view(mesh);
  Shown shown = triangles_of(mesh, map);
  const std::size_t all_faces = shown.faces.size();
  // The number of faces goes with the square of the cells along a side.
  double cells = std::sqrt(static_cast<double>(options.max_faces));
  for (Shown fine = shown; shown.faces.size() > options.max_faces; cells *= 0.8)
    shown = clustered(fine, box.min(), box.diagonal().maxCoeff() / cells);

  const Picture picture = draw(colored(mesh, map), view, 600, 420);
  std::string body = "<h1>" + html_escaped(options.title) + "</h1>\n<p class=\"note\">gpsrecon " +
                     html_escaped(report.version) + ", " + html_escaped(report.command) + "</p>\n" + headline(report);
  body +=
      "<div class=\"columns\"><div>\n<div id=\"view\" data-view=\"picture\"><img alt=\"The mesh coloured by error\" "
      "src=\"data:image/bmp;base64," +
      base64(to_bitmap(picture)) + "\"></div>\n" + legend(map, report.diagonal) +
      "<p class=\"note\" id=\"view-note\">" +
      (map.is_signed ? "Signed distance of the vertices to the reference. "
                     : "Mean distance of the points at each vertex; grey where there are none. ") +
      "Drag to turn, wheel to zoom, right button to shift.</p>\n";
  if (shown.faces.size() < all_faces)
    body += "<p class=\"note\" id=\"thinned\">Shown thinned, with " + count(shown.faces.size()) + " of " +
            count(all_faces) + " triangles; the figures are those of all.</p>\n";
  body += "</div><div>\n" + input_section(report) + "</div></div>\n<h2>Distances</h2>\n" + distance_table(report) +
          direction_table(report) + caveats(report) + charts(report) + topology_section(report) +
          options_section(report);
  return replaced(html_page(), {{"@TITLE@", html_escaped(options.title)},
                                {"@BODY@", body},
                                {"@DATA@", view_data(shown, box, view, map)},
                                {"@VIEWER@", html_viewer()}});
}

}  // namespace gpsrecon
