#pragma once

#include <cstddef>
#include <cstdint>

// The C interface between the library and the plug-in that reads PCD files, so that PCL and what it pulls in are loaded
// only when a PCD file is met. Internal to lib/io.

extern "C" {

struct GpsreconPcdTable {
  std::uint64_t rows;
  std::uint64_t columns;
  const char* const* names;
  const double* const* values;  ///< per column: one number per row; packed colours come as red, green, blue
};

/// Reads the file and hands the table to `receive`, valid for the time of the call. Returns 0, or 1 with the reason in
/// `error`. Throws nothing.
int gpsrecon_read_pcd(const char* path, void (*receive)(void* context, const GpsreconPcdTable* table), void* context,
                      char* error, std::size_t error_size);
using GpsreconReadPcd = decltype(gpsrecon_read_pcd);

}  // extern "C"
