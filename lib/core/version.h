#pragma once

namespace gpsrecon {

/// Of the program, the library and the files they write: major.minor.patch. CMakeLists.txt takes it from here.
inline constexpr const char* version = "0.1.0";

}  // namespace gpsrecon
