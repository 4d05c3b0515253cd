#include <gpsrecon/gps/surface_weights.h>

#include <gpsrecon/gps/patch_table.h>

namespace gpsrecon {

using namespace internal;

JetTable surface_weights(const Connectivity& control, const SurfaceRules& rules,
                         std::span<const SurfaceParameter> parameters, const RunContext& context) {
  return PatchTable(control, rules, context).weights(parameters, context);
}

}  // namespace gpsrecon
