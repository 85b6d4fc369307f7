// SPDX-License-Identifier: BSD-2-Clause
// The list of all factors between frames and planes. The cost, the normal equations and the
// marginalisation go through this list; nobody else names a factor.
#pragma once

#include "facet/estimator/factors/factor_noise.h"
#include "facet/estimator/factors/imu_factor.h"
#include "facet/estimator/factors/prior_factor.h"
#include "facet/estimator/factors/relation_factor.h"
#include "facet/estimator/factors/sighting_factor.h"
#include "facet/estimator/factors/start_prior_factor.h"

namespace facet {

/// Calls `visit` with the sightings of planes.
template <class Visitor>
void VisitSightings(const SlidingWindow& window, const FactorNoise& noise, Visitor&& visit) {
  for (const PlaneSighting& sighting : window.sightings)
    visit(SightingFactor(window, sighting, noise.sighting_huber_sigma));
}

/// Calls `visit` with all factors but the sightings.
template <class Visitor>
void VisitOtherFactors(const SlidingWindow& window, const FactorNoise& noise, Visitor&& visit) {
  if (window.prior.dim() > 0) visit(PriorFactor(window));
  if (window.start_prior) visit(StartPriorFactor(window));
  for (int j = 1; j <= window.newest_frame(); ++j) {
    if (window.frames[j].imu_link) visit(ImuFactor(window, j));
  }
  for (const WindowRelation& relation : window.relations)
    visit(RelationFactor(window, relation, noise.relations));
}

/// Calls `visit` with every factor, each time with another type (see factor.h): a generic lambda
/// does. The order is that of all sums.
template <class Visitor>
void VisitFactors(const SlidingWindow& window, const FactorNoise& noise, Visitor&& visit) {
  VisitOtherFactors(window, noise, visit);
  VisitSightings(window, noise, visit);
}

}  // namespace facet
