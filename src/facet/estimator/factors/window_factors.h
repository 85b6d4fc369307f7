// SPDX-License-Identifier: BSD-2-Clause
// The list of all factors between frames and planes. The cost, the normal equations and the
// marginalisation go through this list; nobody else names a factor.
#pragma once

#include "facet/estimator/factors/calibration_prior_factor.h"
#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/factors/plane_measurement_factor.h"
#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/factors/relation_factor.h"
#include "facet/estimator/factors/start_prior_factor.h"

namespace facet {

template <class Visitor>
void VisitAllButPlaneMeasurements(const SlidingWindow& window,
                                  const FactorNoise& noise,
                                  Visitor&& visit) {
  if (window.prior.dim() > 0) visit(PriorFactor(window));
  if (window.start_prior) visit(StartPriorFactor(window));
  if (window.calibration && window.calibration->start_information)
    visit(CalibrationPriorFactor(*window.calibration));
  for (int j = 1; j <= window.newest_frame(); ++j) {
    if (window.frames[j].imu_link) visit(ImuFactor(window, j));
  }
  for (const WindowRelation& relation : window.relations)
    visit(RelationFactor(window, relation, noise.relations));
}

/// Apart, because one wants to know what the measurements alone say of the planes.
template <class Visitor>
void VisitPlaneMeasurements(const SlidingWindow& window,
                            const FactorNoise& noise,
                            Visitor&& visit) {
  for (const WindowMeasurement& measurement : window.measurements)
    visit(PlaneMeasurementFactor(window, measurement, noise.measurement_huber_sigma));
}

/// Calls `visit` with every factor in the window. They are of different types (see factor.h), so a
/// visitor is a generic lambda: [&](const Factor auto& factor) { ... }. In this order all sums are
/// taken.
template <class Visitor>
void VisitFactors(const SlidingWindow& window, const FactorNoise& noise, Visitor&& visit) {
  VisitAllButPlaneMeasurements(window, noise, visit);
  VisitPlaneMeasurements(window, noise, visit);
}

}  // namespace facet
