// Seeds for fuzzing: small valid inputs for every target, made when they are needed.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "harness.h"

namespace fluxgs::fuzz {

/// target → name → input.
using Seeds = std::map<std::string, std::map<std::string, Bytes>>;

/// All of them; real ones if FLUXGS_DATA names a folder with real scenes.
Seeds make_seeds();

/// By our own writers and by hand: all formats, versions and degrees.
void add_own_seeds(Seeds& seeds);

/// From the real files below `data`, cut down to a few splats each where they are large. Files that
/// are not there are left out; what cannot be cut is reported on standard error.
void add_real_seeds(Seeds& seeds, const std::filesystem::path& data);

}  // namespace fluxgs::fuzz
