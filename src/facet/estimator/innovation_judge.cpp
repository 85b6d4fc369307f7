// SPDX-License-Identifier: BSD-2-Clause
#include "facet/estimator/innovation_judge.h"

namespace facet {

namespace {

// Fewer say nothing: a handful agrees with anything.
constexpr int kMinLandmarks = 8;
constexpr double kMinAgreeingShare = 0.25;
constexpr double kConfirmingShare = 0.5;
// For how long an IMU that witnesses have confirmed is believed when there are none left.
constexpr Duration kConfirmedFor{2'000'000'000};
// Keyframes at which a landmark that has moved must agree before it is used again.
constexpr int kProbation = 3;

}  // namespace

bool InnovationJudge::LeavesOut(const InnovationTest& test, Timestamp t) {
  if (test.num_witnesses >= kMinLandmarks) {
    const double agreeing = test.num_witnesses - test.num_contradicting_witnesses;
    if (agreeing > kConfirmingShare * test.num_witnesses) t_confirmed_ = t;
    return agreeing >= kMinAgreeingShare * test.num_witnesses;
  }
  if (t_confirmed_ && t - *t_confirmed_ < kConfirmedFor) return true;
  const int num_agreeing = test.num_tested - test.num_contradicting;
  return num_agreeing >= kMinLandmarks && num_agreeing >= kMinAgreeingShare * test.num_tested;
}

void Remember(const InnovationTest& test,
              const std::vector<PreparedObservation>& observations,
              SlidingWindow& window) {
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (!test.agrees[i] && !test.contradicts[i]) continue;
    WindowLandmark* landmark = window.Find(observations[i].landmark);
    if (landmark == nullptr) continue;
    landmark->num_confirmed = test.contradicts[i] ? -kProbation : landmark->num_confirmed + 1;
  }
}

void LeaveOutMoving(const InnovationTest& test,
                    SlidingWindow& window,
                    std::vector<PreparedObservation>& observations) {
  auto contradicts = test.contradicts.begin();
  std::erase_if(observations, [&](const PreparedObservation& o) {
    if (*contradicts++) return true;
    const WindowLandmark* landmark = window.Find(o.landmark);
    return landmark != nullptr && landmark->IsOnProbation();
  });
}

}  // namespace facet
