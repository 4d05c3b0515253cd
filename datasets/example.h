#pragma once

#include "datasets/virtual_scan.h"

namespace gpsrecon::datasets {

/// The solid of the embedded example: a ball with a bore, a flat-topped boss, a knob on a filleted neck, a conical pit
/// and a flat. One closed surface of genus 1. See datasets/README.md.
TurnedBall example_solid();

/// How the embedded example is scanned, with `example_seed`.
ScanOptions example_scan();
inline constexpr std::uint64_t example_seed = 1;

}  // namespace gpsrecon::datasets
