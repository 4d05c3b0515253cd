#include "error_views.h"

#include <gpsrecon/io/io.h>
#include <gpsrecon/report/html_report.h>

namespace gpsrecon::cli {

void ErrorViews::plan(Outputs& outputs) const {
  outputs.plan({"--heatmap", heatmap}, true);
  outputs.plan({"--html", html});
}

void ErrorViews::stage(Outputs& outputs, const ErrorReport& report, const Mesh& mesh,
                       const std::function<ErrorMap(double range)>& map_of, const std::string& title,
                       const Console& console) const {
  if (!wanted()) return;
  const ErrorMap map = map_of(heatmap_max.resolve({.diagonal = report.diagonal}, "heatmap-max"));
  console.info(map.is_signed ? "colours: signed distance, blue (inside) over white to red (outside), from -" +
                                   std::to_string(map.range) + " to " + std::to_string(map.range)
                             : "colours: distance, viridis, dark blue (0) to yellow (" + std::to_string(map.range) +
                                   " and more); grey where there are no points");
  if (!heatmap.empty()) {
    const Mesh coloured = colored(mesh, map);
    warn_of_losses(coloured, heatmap, console);
    outputs.stage(heatmap, [&](const std::string& path) { write_mesh(coloured, path); });
  }
  outputs.stage(html, [&](const std::string& path) {
    HtmlOptions options;
    options.title = title;
    write_text(html_report(report, mesh, map, options), path);
  });
}

}  // namespace gpsrecon::cli
