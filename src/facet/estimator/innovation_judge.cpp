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
// Of the landmarks that are no witnesses: if more contradict, much of what has come into view
// moves.
constexpr double kMovingShare = 2.0 / 3;

int NumAgreeingWitnesses(const InnovationTest& test) {
  return test.num_witnesses - test.num_contradicting_witnesses;
}

bool DoWitnessesAgree(const InnovationTest& test) {
  return test.num_witnesses >= kMinLandmarks &&
         NumAgreeingWitnesses(test) > kConfirmingShare * test.num_witnesses;
}

// Whether what agrees without being a witness may do so by chance: it is in a crowd that moves. The
// crowd has to outnumber the witnesses; otherwise the loss of the solver deals with the few.
bool OnlyWitnessesCount(const InnovationTest& test) {
  const int num_others = test.num_tested - test.num_witnesses;
  const int num_moving = test.num_contradicting - test.num_contradicting_witnesses;
  return DoWitnessesAgree(test) && NumAgreeingWitnesses(test) >= kMinLandmarks &&
         num_others > test.num_witnesses && num_moving > kMovingShare * num_others;
}

}  // namespace

bool InnovationJudge::LeavesOut(const InnovationTest& test, Timestamp t) {
  if (test.num_witnesses >= kMinLandmarks) {
    if (DoWitnessesAgree(test)) t_confirmed_ = t;
    return NumAgreeingWitnesses(test) >= kMinAgreeingShare * test.num_witnesses;
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
  const bool only_witnesses = OnlyWitnessesCount(test);
  std::size_t next = 0;
  std::erase_if(observations, [&](const PreparedObservation& o) {
    const std::size_t i = next++;
    if (test.contradicts[i]) return true;
    const WindowLandmark* landmark = window.Find(o.landmark);
    if (landmark == nullptr) return false;
    return landmark->IsOnProbation() || (only_witnesses && test.agrees[i] && !test.is_witness[i]);
  });
}

}  // namespace facet
