// Previews of a training: the growing scene in a window, and pictures of one view.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tools/fluxgs/commands/train_run.h"
#include "tools/fluxgs/terminal/child_process.h"
#include "tools/fluxgs/terminal/files.h"

namespace fluxgs::cli {

/// The folder of the pictures, beside the output.
std::string preview_folder(const TrainSettings& settings);

class Preview {
 public:
  /// Opens the window (--preview): fluxgs view, which follows a file. `settings` and `data` must
  /// outlive it.
  Preview(const TrainSettings& settings, const Dataset& data);

  /// After an iteration: renews the window's file every few seconds, in less than a twentieth of
  /// the time, and writes the picture that is due. What fails is a warning, once.
  void update(const Trainer& trainer);

 private:
  void renew_window(const Trainer& trainer);
  void write_picture(const Trainer& trainer);
  Expected<void> write_scene_file(const Trainer& trainer) const;

  const TrainSettings& settings_;
  const Dataset& data_;
  std::optional<TempFolder> folder_;  // of the window's file
  std::string file_;
  std::unique_ptr<ChildProcess> window_;
  double next_ = 0;  // time at which the file is renewed
  bool pictures_;
};

}  // namespace fluxgs::cli
