// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/error_evidence.h"

#include <algorithm>
#include <cmath>

namespace facet {
namespace {

// Of the information on an error; less of it that was measured is rounding.
constexpr double kLeastMeasured = 1e-6;

}  // namespace

// Without the belief the measurements say m with covariance S. They are explained by N(0, S + B)
// with the belief B, or N(0, S + B + e e^T). With a = e^T (S + B)^-1 e and u = e^T (S + B)^-1 m
// the determinant grows by 1 + a, and the squares become less by u^2 / (1 + a). What is left is
// (S^-1 + B^-1)^-1, and delta = B (S + B)^-1 m.
ErrorVerdict JudgeError(const CalibrationVector& error,
                        const CalibrationMatrix& before,
                        const CalibrationVector& delta,
                        const CalibrationMatrix& left) {
  const CalibrationVector pulled = before * error, moved = left * pulled;
  const double u = pulled.dot(delta);
  const double believed = pulled.dot(error), a = believed - pulled.dot(moved);
  if (!(a > kLeastMeasured * believed)) return {0, delta};
  return {u * u / (1 + a) - std::log1p(a), delta + u / (1 + a) * moved};
}

// One after the other: each has what is left by those before it.
FreedEstimate FreeErrors(std::span<const CalibrationVector> errors,
                         const CalibrationMatrix& before,
                         const CalibrationVector& delta,
                         const CalibrationMatrix& left) {
  FreedEstimate freed{0, delta, left};
  CalibrationMatrix now = before;
  for (const CalibrationVector& error : errors) {
    const ErrorVerdict verdict = JudgeError(error, now, freed.delta, freed.left);
    freed.evidence += verdict.evidence;
    freed.delta = verdict.delta;
    const CalibrationVector pulled = now * error, moved = freed.left * pulled;
    const double a = std::max(pulled.dot(error) - pulled.dot(moved), 0.0);  // as in JudgeError
    freed.left += moved * moved.transpose() / (1 + a);
    now += RoomForError(error, now);
  }
  return freed;
}

CalibrationMatrix RoomForError(const CalibrationVector& error, const CalibrationMatrix& before) {
  const CalibrationVector pulled = before * error;
  return -pulled * pulled.transpose() / (1 + pulled.dot(error));
}

CalibrationMatrix RoomForErrors(std::span<const CalibrationVector> errors,
                                const CalibrationMatrix& before) {
  CalibrationMatrix now = before;
  for (const CalibrationVector& error : errors)
    now += RoomForError(error, now);
  return now - before;
}

}  // namespace facet
