// COLMAP as a program: finds it and its options, and runs its commands.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/core/process.h"

namespace fluxgs {

/// An error that names `photos` if COLMAP is not on PATH.
Expected<void> check_colmap_installed(const std::filesystem::path& photos);

class ColmapProgram {
 public:
  /// `log`: what COLMAP writes is appended there. Errors: COLMAP is not on PATH.
  static Expected<ColmapProgram> find(const std::filesystem::path& log);

  /// True if COLMAP was built with CUDA and nvidia-smi finds a GPU.
  bool has_gpu() const { return has_gpu_; }

  /// The full name of an option of a command by its end, which is the same in all versions; empty
  /// if there is none.
  std::string option(const std::string& command, std::string_view end) const;

  using LineSink = std::function<void(std::string_view line)>;
  /// Runs a command to its end. Errors: anything but status 0, with COLMAP's last complaint.
  /// `status`, where it is not null, receives the exit status, or −1 if there was none.
  Expected<void> run(const std::string& command, const std::vector<std::string>& arguments,
                     const LineSink& on_line, int* status = nullptr) const;

 private:
  ColmapProgram(std::filesystem::path program, std::filesystem::path log)
      : program_(std::move(program)), log_(std::move(log)) {}
  std::string help_of(const std::string& command) const;

  std::filesystem::path program_, log_;
  bool has_gpu_ = false;
};

}  // namespace fluxgs
