// Standard streams that may be closed, full or gone.
#pragma once

#include <string>
#include <string_view>

#include "fluxgs/error.h"

namespace fluxgs::cli {

/// Opens what is closed of standard input, output and error, so that no file gets their numbers and
/// receives what was meant for them. Output to a closed standard output is an error later.
void guard_standard_streams();

/// To standard error, now. Never fails: a lost message must not end long work.
void say(std::string_view text);

/// An error if anything printed to standard output was lost.
Expected<void> flush_standard_output();

/// "40.00 dB", "exact" for infinity.
std::string decibels(double psnr);

/// A path as a shell takes it.
std::string shell_quoted(const std::string& text);

}  // namespace fluxgs::cli
