// SPDX-License-Identifier: BSD-2-Clause
// The runs of a report in 3D, and in the images of the camera.
#pragma once

#include "facet/eval/ground_truth.h"
#include "facet/report/report_page.h"

namespace facet {

/// Adds the viewer's page with the first and the last run of the section that have a result folder
/// with a mesh. A section without one, or whose page would be too large for a browser, has none.
void AddScene(GroundTruth truth, ReportSection& section);

/// Adds what the left camera saw at some moments of the section's last run, with its mesh over it,
/// where the truth is that of a folder with images.
void AddCameraImages(const GroundTruth& truth, ReportSection& section);

}  // namespace facet
