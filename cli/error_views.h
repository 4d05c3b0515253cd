#pragma once

#include <gpsrecon/report/heatmap.h>
#include <gpsrecon/report/report.h>
#include <functional>
#include <string>

#include "arguments.h"
#include "console.h"
#include "outputs.h"

namespace gpsrecon::cli {

/// The files in which errors can be looked at: a coloured mesh and a page.
struct ErrorViews {
  std::string heatmap, html;
  Length heatmap_max = {};

  static OptionTable fields() {
    using O = ErrorViews;
    return {field<&O::heatmap>(
                "heatmap", "",
                "the mesh coloured by error, with the error as a column (ply; off and obj hold the colours)"),
            field<&O::heatmap_max>("heatmap-max", "> 0", "error that has the last colour; auto = the 99th percentile"),
            field<&O::html>("html", "",
                            "the report as a page that opens from disk, with diagrams and the mesh in 3-D coloured by "
                            "error")};
  }
  bool wanted() const { return !heatmap.empty() || !html.empty(); }
  void plan(Outputs& outputs) const;
  /// Stages the files. `map_of` is given the range that was asked for in scene units, 0 for the automatic one.
  void stage(Outputs& outputs, const ErrorReport& report, const Mesh& mesh,
             const std::function<ErrorMap(double range)>& map_of, const std::string& title,
             const Console& console) const;
};

}  // namespace gpsrecon::cli
