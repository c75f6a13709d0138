// What an ablation compares: presets, and a preset with some of its options changed.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fluxgs/error.h"
#include "trainer/model/options.h"

namespace fluxgs::cli {

/// Rows that make a table and an image together.
struct SweepGroup {
  std::string name, title;
  std::string x_label = "";  ///< of the option that changes; empty: size is drawn against error
  bool log_x = false;
};

/// One line of a table.
struct SweepRow {
  std::string group, name;  ///< both are words of --only; the name is that of a folder, too
  std::string label;        ///< what people read
  std::string preset;
  std::vector<std::string> options;  ///< of `fluxgs train`, as typed, on top of the preset
  std::string series = "";           ///< rows of one series are joined in an image
  std::optional<double> x = {};      ///< where in the image; none: by the size of its files
};

const std::vector<SweepGroup>& sweep_groups();

/// Every row there is.
std::vector<SweepRow> all_sweep_rows();

/// The rows of these groups or names, in the order of the table; all of them for none. `preset`, if
/// not empty, takes the place of every row's own but in the group "presets". Errors: a name that is
/// neither, or that preset does not exist.
Expected<std::vector<SweepRow>> chosen_sweep_rows(const std::vector<std::string>& only,
                                                  const std::string& preset);

/// The options of `train` in both lists, those that `changes` sets with its values alone.
std::vector<std::string> merged_options(const std::vector<std::string>& common,
                                        const std::vector<std::string>& changes);

/// Those of the options that have one of these names, with their values.
std::vector<std::string> picked_options(const std::vector<std::string>& options,
                                        std::initializer_list<std::string_view> names);

/// What these options of `train` mean, every constant of the method resolved. Options that are not
/// of the method are passed over. Errors: unknown preset, values that are refused.
Expected<TrainOptions> meaning_of(const std::string& preset,
                                  const std::vector<std::string>& options);

}  // namespace fluxgs::cli
