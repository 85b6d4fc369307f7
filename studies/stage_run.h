// SPDX-License-Identifier: BSD-2-Clause
// The pipeline's stages run over a recording one by one, open to look at what passes between them.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "facet/io/asl_dataset.h"
#include "facet/pipeline/front_stage.h"
#include "facet/pipeline/vio_options.h"
#include "facet/pipeline/vio_output.h"

namespace facet {

/// Pipeline S without mesh, but for what the overrides (key=value) say. Throws ConfigError.
VioOptions OptionsOfS(const std::vector<std::string>& overrides);

/// A frame between its front and its back half: its place in the sequence, its images, and what the
/// back half will get, which may be changed. False ends the run before the back half.
using VisitTracked = std::function<bool(std::size_t index, const StereoFrame&, TrackedFrame&)>;

/// Calls `visit` and then, after the back half, `take_output`, once for each frame. Throws
/// InputError.
void RunStages(AslDataset& dataset,
               const StereoRig& rig,
               const VioOptions& options,
               const VisitTracked& visit,
               const std::function<void(const VioOutput&)>& take_output);

/// The same with the rig of the dataset.
void RunStages(AslDataset& dataset,
               const VioOptions& options,
               const VisitTracked& visit,
               const std::function<void(const VioOutput&)>& take_output);

}  // namespace facet
