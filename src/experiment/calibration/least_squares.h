// Weighted linear least squares, with Eigen.
#pragma once

#include <cstddef>
#include <vector>

namespace kerf {

/// Minimise chi2 = sum over i of weight_i (value_i - sum over j of design_ij c_j)^2.
struct LinearProblem {
  std::size_t columns = 0;
  std::vector<double> design;   // by row
  std::vector<double> values;   // of each row
  std::vector<double> weights;  // of each row, >= 0

  std::size_t rows() const { return values.size(); }
};

struct LinearFit {
  bool determined = false;  // the design has full rank; if not, the rest is not set
  std::vector<double> coefficients;
  std::vector<double>
      covariance;  // (X' W X)^-1 by row, columns x columns: to be multiplied by the variance of weight 1
  double chi2 = 0;
};

/// Solves by a QR decomposition with column pivoting, with columns scaled to equal length.
LinearFit FitLeastSquares(const LinearProblem& problem);

struct NonNegativeFit {
  LinearFit unconstrained;
  LinearFit fit;          // of all coefficients; the covariance of those at 0 is 0
  unsigned zero_set = 0;  // a bit for each coefficient that is 0 because it would be negative

  bool IsAtZero(std::size_t coefficient) const { return (zero_set >> coefficient & 1u) != 0; }
};

/// Solves with all coefficients >= 0. Unlike setting negative ones to 0, this fits the others again: of all sets of
/// coefficients at 0 that leave the others positive, it takes the one with the lowest chi2. For at most 8 coefficients.
NonNegativeFit FitNonNegative(const LinearProblem& problem);

}  // namespace kerf
