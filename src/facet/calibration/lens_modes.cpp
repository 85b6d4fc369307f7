// SPDX-License-Identifier: BSD-2-Clause
#include "facet/calibration/lens_modes.h"

#include <cmath>
#include <initializer_list>

#include <Eigen/Cholesky>

#include "facet/base/check.h"

namespace facet {
namespace {

constexpr int kNumAll = 2 * kNumMonomials;
constexpr int kNumExplained = kNumAll - kNumLensModes;

using Fields = Matrix<kNumAll, kNumAll>;

struct Term {
  int axis;  // of the displacement
  int power_u, power_v;
  double factor = 1;
};

// u = x and v = aspect * y have the same unit; x and y go from -1 to 1 over the image. A column has
// the monomials in x and y of the displacement along x, then of that along y.
class FieldList {
 public:
  explicit FieldList(double aspect) : aspect_(aspect) {}

  void Add(std::initializer_list<Term> terms) {
    for (const Term& term : terms)
      fields_(term.axis * kNumMonomials + MonomialIndex(term.power_u, term.power_v), num_) +=
          term.factor * std::pow(aspect_, term.power_v);
    ++num_;
  }

  const Fields& all() const {
    FACET_CHECK(num_ == kNumAll) << num_ << " fields";
    return fields_;
  }

 private:
  double aspect_;
  Fields fields_ = Fields::Zero();
  int num_ = 0;
};

// All polynomials of third order: first those that other parameters explain.
Fields AllFields(double aspect) {
  FieldList list(aspect);
  list.Add({{0, 0, 0}});  // principal point, turns across
  list.Add({{1, 0, 0}});
  list.Add({{0, 1, 0}});  // focal lengths
  list.Add({{1, 0, 1}});
  list.Add({{0, 0, 1, -1}, {1, 1, 0}});  // a turn about the axis
  list.Add({{0, 2, 0}, {1, 1, 1}});      // turns across
  list.Add({{0, 1, 1}, {1, 0, 2}});
  list.Add({{0, 2, 0}, {0, 0, 2}});  // those and tangential distortion
  list.Add({{1, 2, 0}, {1, 0, 2}});
  list.Add({{0, 3, 0}, {0, 1, 2}, {1, 2, 1}, {1, 0, 3}});  // radial distortion
  list.Add({{0, 0, 1}, {1, 1, 0}});
  for (const int axis : {0, 1}) {
    list.Add({axis == 0 ? Term{0, 0, 2} : Term{1, 2, 0}});
    list.Add({{axis, 3, 0}});
    list.Add({{axis, 2, 1}});
    list.Add({{axis, 1, 2}});
    if (axis == 0) list.Add({{0, 0, 3}});
  }
  return list.all();
}

}  // namespace

LensModes::LensModes(int width, int height) : width_(width), height_(height) {
  const Fields all = AllFields(static_cast<double>(height - 1) / (width - 1));
  const auto moments = SmoothField::Moments();
  Fields products = Fields::Zero();
  for (const int axis : {0, 1})
    products.block<kNumMonomials, kNumMonomials>(axis * kNumMonomials, axis * kNumMonomials) =
        moments;
  // Each field without what those before it say (Gram and Schmidt): columns of E L^-T.
  const Eigen::LLT<Fields> factor(all.transpose() * products * all);
  Fields orthogonal = factor.matrixL().solve(all.transpose());
  orthogonal *= std::sqrt(2.0);  // one pixel over both axes
  for (int k = 0; k < kNumLensModes; ++k) {
    const auto mode = orthogonal.row(kNumExplained + k);
    coefficients_.row(2 * k) = mode.head<kNumMonomials>();
    coefficients_.row(2 * k + 1) = mode.tail<kNumMonomials>();
  }
}

Matrix<2, kNumLensModes> LensModes::At(const Vector2d& px) const {
  const Vector<kNumMonomials> m = SmoothField::Monomials(px, width_, height_);
  Matrix<2, kNumLensModes> at;
  Eigen::Map<Vector<2 * kNumLensModes>> all(at.data());
  all = m(0) * coefficients_.col(0);
  for (int i = 1; i < kNumMonomials; ++i)
    all += m(i) * coefficients_.col(i);
  return at;
}

SmoothField LensModes::Sum(const LensModeVector& amounts) const {
  Matrix<kNumMonomials, 2> coefficients = Matrix<kNumMonomials, 2>::Zero();
  for (int k = 0; k < kNumLensModes; ++k)
    coefficients += amounts(k) * coefficients_.middleRows<2>(2 * k).transpose();
  return SmoothField(width_, height_, coefficients);
}

LensFields FieldsOf(const StereoRig& rig) {
  LensFields fields;
  for (std::size_t c = 0; c < 2; ++c) {
    if (!rig.lens_modes[c].isZero(0)) fields[c] = LensModes(rig.cameras[c]).Sum(rig.lens_modes[c]);
  }
  return fields;
}

}  // namespace facet
