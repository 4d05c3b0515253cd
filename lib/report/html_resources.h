#pragma once

#include <string_view>

// Internal to lib/report: files of lib/report/html, part of the library.

namespace gpsrecon::internal {

/// The page with @TITLE@, @BODY@, @DATA@ and @VIEWER@ where these go.
std::string_view html_page();
/// The script of the 3-D view.
std::string_view html_viewer();

}  // namespace gpsrecon::internal
