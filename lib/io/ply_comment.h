#pragma once

#include <gpsrecon/core/frame.h>
#include <gpsrecon/core/surface_rules.h>
#include <optional>
#include <string>

#include "ply_header.h"

// Internal to lib/io: the comment by which files of this program carry what has no column,
// "gpsrecon <version> frame <ox> <oy> <oz> <exponent> sigma0 <s> spacing <a>", sigma0 and spacing in world units, 0 if
// unknown. Comments without the last two words are read too. Another, "gpsrecon <version> labels <column> ...", names
// the columns that hold labels; a third, of covariance meshes, "gpsrecon <version> scheme loop|catmull-clark weights
// loop|warren corners smooth|sharp", the rules of their surface.

namespace gpsrecon::internal::io {

struct FrameComment {
  Frame frame;
  double sigma0 = 0;   ///< in units of the world
  double spacing = 0;  ///< likewise
};

/// "gpsrecon <version>", which points and meshes carry too.
std::string version_comment();

/// The numbers are written so that they are read back bit for bit.
std::string frame_comment(const FrameComment& comment);

/// Precondition: there are columns.
std::string label_comment(const std::vector<std::string>& columns);
/// The columns that the comments of the header name as labels.
std::vector<std::string> find_label_comment(const PlyHeader& header);

std::string rules_comment(const SurfaceRules& rules);
/// The first comment of the header that carries rules, if there is one. Throws InputError if it is malformed.
std::optional<SurfaceRules> find_rules_comment(const InputFile& file, const PlyHeader& header);

/// The first comment of the header that carries a frame; the identity if there is none. Throws InputError if it is
/// malformed.
FrameComment find_frame_comment(const InputFile& file, const PlyHeader& header);

}  // namespace gpsrecon::internal::io
