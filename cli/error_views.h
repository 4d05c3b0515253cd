#pragma once

#include <gpsrecon/report/heatmap.h>
#include <functional>
#include <string>

#include "arguments.h"
#include "console.h"
#include "outputs.h"

namespace gpsrecon::cli {

/// The files in which errors can be looked at: a coloured mesh and a page.
class ErrorViews {
 public:
  /// Declares --heatmap, --heatmap-max and --html.
  void bind(Arguments& arguments);
  bool wanted() const { return !heatmap_.empty() || !html_.empty(); }
  void plan(Outputs& outputs) const;
  /// Stages the files. `map_of` is given the range that was asked for, 0 for the automatic one.
  void stage(Outputs& outputs, const ErrorReport& report, const Mesh& mesh,
             const std::function<ErrorMap(double range)>& map_of, const std::string& title,
             const Console& console) const;

 private:
  std::string heatmap_, html_;
  double range_ = 0;
};

}  // namespace gpsrecon::cli
