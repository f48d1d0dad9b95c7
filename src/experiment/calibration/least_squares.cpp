#include "experiment/calibration/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace kerf {
namespace {

/// Columns that depend on each other to this relative accuracy can't be separated.
constexpr double kRankThreshold = 1e-10;

/// Returns the problem with only the columns that are not at zero.
LinearProblem SelectColumns(const LinearProblem& problem, unsigned zero_set) {
  LinearProblem part;
  part.values = problem.values;
  part.weights = problem.weights;
  part.columns = problem.columns - static_cast<std::size_t>(std::popcount(zero_set));
  for (std::size_t i = 0; i < problem.rows(); ++i) {
    for (std::size_t j = 0; j < problem.columns; ++j) {
      if ((zero_set >> j & 1u) == 0) part.design.push_back(problem.design[i * problem.columns + j]);
    }
  }
  return part;
}

/// Sets coefficients to 0 that are negative only because of rounding errors.
void RemoveRoundingErrors(const LinearProblem& problem, std::vector<double>& coefficients) {
  constexpr double kRounding = 1e-12;  // of the coefficient with which its column alone would have the values' length
  double values = 0;
  for (std::size_t i = 0; i < problem.rows(); ++i) values += problem.weights[i] * problem.values[i] * problem.values[i];
  for (std::size_t j = 0; j < coefficients.size(); ++j) {
    double column = 0;
    for (std::size_t i = 0; i < problem.rows(); ++i) {
      const double x = problem.design[i * problem.columns + j];
      column += problem.weights[i] * x * x;
    }
    if (coefficients[j] < 0 && coefficients[j] >= -kRounding * std::sqrt(values / column)) coefficients[j] = 0;
  }
}

/// Inserts zeros for the coefficients at zero.
LinearFit InsertZeros(const LinearFit& part, std::size_t count, unsigned zero_set) {
  LinearFit whole;
  whole.determined = part.determined;
  whole.chi2 = part.chi2;
  whole.coefficients.assign(count, 0);
  whole.covariance.assign(count * count, 0);
  std::vector<std::size_t> free;
  for (std::size_t j = 0; j < count; ++j) {
    if ((zero_set >> j & 1u) == 0) free.push_back(j);
  }
  for (std::size_t a = 0; a < free.size(); ++a) {
    whole.coefficients[free[a]] = part.coefficients[a];
    for (std::size_t b = 0; b < free.size(); ++b) {
      whole.covariance[free[a] * count + free[b]] = part.covariance[a * free.size() + b];
    }
  }
  return whole;
}

}  // namespace

LinearFit FitLeastSquares(const LinearProblem& problem) {
  LinearFit fit;
  const auto rows = static_cast<Eigen::Index>(problem.rows());
  const auto columns = static_cast<Eigen::Index>(problem.columns);
  const Eigen::ArrayXd root = Eigen::Map<const Eigen::ArrayXd>(problem.weights.data(), rows).sqrt();
  const Eigen::VectorXd values = root * Eigen::Map<const Eigen::ArrayXd>(problem.values.data(), rows);
  if (columns == 0) {
    fit.determined = true;
    fit.chi2 = values.squaredNorm();
    return fit;
  }
  if (rows < columns) return fit;
  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::MatrixXd design = Eigen::Map<const RowMajor>(problem.design.data(), rows, columns);
  design.array().colwise() *= root;
  const Eigen::VectorXd scale = design.colwise().norm().transpose();
  if (!(scale.minCoeff() > 0)) return fit;
  design.array().rowwise() /= scale.transpose().array();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(design);
  qr.setThreshold(kRankThreshold);
  if (qr.rank() < columns) return fit;
  fit.determined = true;
  const Eigen::VectorXd scaled = qr.solve(values);
  fit.chi2 = (values - design * scaled).squaredNorm();
  // (X' X)^-1 = P R^-1 R^-T P', with X P = Q R.
  const Eigen::MatrixXd inverse =
      qr.matrixR().topRows(columns).triangularView<Eigen::Upper>().solve(Eigen::MatrixXd::Identity(columns, columns));
  const Eigen::MatrixXd permuted = qr.colsPermutation() * inverse;
  const Eigen::MatrixXd covariance = permuted * permuted.transpose();
  for (Eigen::Index a = 0; a < columns; ++a) {
    fit.coefficients.push_back(scaled[a] / scale[a]);
    for (Eigen::Index b = 0; b < columns; ++b) fit.covariance.push_back(covariance(a, b) / (scale[a] * scale[b]));
  }
  return fit;
}

NonNegativeFit FitNonNegative(const LinearProblem& problem) {
  NonNegativeFit best;
  best.unconstrained = FitLeastSquares(problem);
  if (best.unconstrained.determined) RemoveRoundingErrors(problem, best.unconstrained.coefficients);
  best.fit = best.unconstrained;
  const auto valid = [](const LinearFit& fit) {
    return std::all_of(fit.coefficients.begin(), fit.coefficients.end(), [](double c) { return c >= 0; });
  };
  if (!best.unconstrained.determined || valid(best.unconstrained)) return best;
  double least = std::numeric_limits<double>::infinity();
  for (unsigned set = 1; set < (1u << problem.columns); ++set) {
    const LinearFit part = FitLeastSquares(SelectColumns(problem, set));
    if (!part.determined || !valid(part) || part.chi2 >= least) continue;
    least = part.chi2;
    best.zero_set = set;
    best.fit = InsertZeros(part, problem.columns, set);
  }
  return best;
}

}  // namespace kerf
