#include "core/diagnosis/likelihood.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace tissued::core {

namespace {

// The frames of one channel in which something was seen, over all trials.
struct ChannelRows {
  Eigen::VectorXd residual;
  Eigen::MatrixXd derivatives, basis;  // (rows x parameters), (rows x 1 + 2 trials)
};

ChannelRows rows_of(int channel, std::span<const TrialResidual* const> trials, Eigen::Index parameters) {
  Eigen::Index count = 0;
  for (const TrialResidual* trial : trials)
    for (Eigen::Index f = 0; f < trial->residual.rows(); ++f) count += std::isfinite(trial->residual(f, channel));
  ChannelRows rows{Eigen::VectorXd(count), Eigen::MatrixXd(count, parameters),
                   Eigen::MatrixXd::Zero(count, 1 + 2 * static_cast<Eigen::Index>(trials.size()))};
  Eigen::Index row = 0;
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const TrialResidual& trial = *trials[k];
    for (Eigen::Index f = 0; f < trial.residual.rows(); ++f) {
      if (!std::isfinite(trial.residual(f, channel))) continue;
      rows.residual[row] = trial.residual(f, channel);
      for (Eigen::Index j = 0; j < parameters; ++j)
        rows.derivatives(row, j) = trial.derivatives[static_cast<std::size_t>(j)](f, channel);
      rows.basis(row, 0) = 1.0;
      const auto first = 1 + 2 * static_cast<Eigen::Index>(k);
      rows.basis(row, first) = trial.load[f];
      rows.basis(row, first + 1) = 4.0 * trial.load[f] * (1.0 - trial.load[f]);
      ++row;
    }
  }
  return rows;
}

// Standard deviations of what the columns of ChannelRows::basis are multiplied by.
Eigen::VectorXd spread_of(const ErrorModel& errors, Eigen::Index channel,
                          std::span<const TrialResidual* const> trials) {
  Eigen::VectorXd spread = Eigen::VectorXd::Zero(1 + 2 * static_cast<Eigen::Index>(trials.size()));
  spread[0] = errors.offset[channel];
  for (std::size_t k = 0; k < trials.size(); ++k) {
    const auto first = 1 + 2 * static_cast<Eigen::Index>(k);
    spread[first] = errors.discretisation(trials[k]->trial, channel);
    if (errors.bend.size() > 0) spread[first + 1] = errors.bend(trials[k]->trial, channel);
  }
  return spread;
}

}  // namespace

NormalEquations normal_equations(const ErrorModel& errors, std::span<const TrialResidual* const> trials) {
  NormalEquations sum;
  if (trials.empty()) return sum;
  const auto parameters = static_cast<Eigen::Index>(trials.front()->derivatives.size());
  const Eigen::Index channels = errors.noise.size();
  sum.gradient.setZero(parameters);
  sum.normal.setZero(parameters, parameters);
  sum.chi_square_of_channel.setZero(channels);
  sum.count_of_channel.setZero(channels);
  for (Eigen::Index c = 0; c < channels; ++c) {
    const ChannelRows rows = rows_of(static_cast<int>(c), trials, parameters);
    if (rows.residual.size() == 0) continue;
    const double weight = 1.0 / (errors.noise[c] * errors.noise[c]);
    const Eigen::VectorXd spread = spread_of(errors, c, trials);
    // (I / weight + B B^T)^-1 = weight I - weight^2 B (I + weight B^T B)^-1 B^T, B scaled by its spread.
    const Eigen::MatrixXd basis = rows.basis * spread.asDiagonal();
    Eigen::MatrixXd inner = weight * basis.transpose() * basis;
    inner.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> factor(inner);
    const Eigen::VectorXd basis_residual = factor.matrixL().solve(basis.transpose() * rows.residual);
    const Eigen::MatrixXd basis_derivatives = factor.matrixL().solve(basis.transpose() * rows.derivatives);
    const double square = weight * rows.residual.squaredNorm() - weight * weight * basis_residual.squaredNorm();
    sum.chi_square += square;
    sum.chi_square_of_channel[c] = square;
    sum.count_of_channel[c] = static_cast<double>(rows.residual.size());
    sum.count += static_cast<int>(rows.residual.size());
    sum.gradient += weight * rows.derivatives.transpose() * rows.residual -
                    weight * weight * basis_derivatives.transpose() * basis_residual;
    sum.normal += weight * rows.derivatives.transpose() * rows.derivatives -
                  weight * weight * basis_derivatives.transpose() * basis_derivatives;
  }
  return sum;
}

Nuisances nuisances(const ErrorModel& errors, std::span<const TrialResidual* const> trials) {
  const Eigen::Index channels = errors.noise.size(), count = static_cast<Eigen::Index>(trials.size());
  Nuisances out{Eigen::VectorXd::Zero(channels), RowMatrix::Zero(count, channels), RowMatrix::Zero(count, channels)};
  for (Eigen::Index c = 0; c < channels; ++c) {
    const ChannelRows rows = rows_of(static_cast<int>(c), trials, 0);
    if (rows.residual.size() == 0) continue;
    const Eigen::VectorXd spread = spread_of(errors, c, trials);
    const Eigen::MatrixXd basis = rows.basis * spread.asDiagonal();
    Eigen::MatrixXd inner = basis.transpose() * basis;
    inner.diagonal().array() += errors.noise[c] * errors.noise[c];
    const Eigen::VectorXd mean =
        spread.asDiagonal() * inner.llt().solve(Eigen::VectorXd(basis.transpose() * rows.residual));
    out.offset[c] = mean[0];
    for (Eigen::Index k = 0; k < count; ++k) {
      out.discretisation(k, c) = mean[1 + 2 * k];
      out.bend(k, c) = mean[2 + 2 * k];
    }
  }
  return out;
}

std::array<double, 3> structure_left(const ErrorModel& errors, const Channels& channels,
                                     std::span<const TrialResidual* const> trials, int bin) {
  const Nuisances known = nuisances(errors, trials);
  std::array<double, 3> square{}, bins{};
  for (int c = 0; c < channels.count(); ++c) {
    const int kind = channels.is_marker(c) ? 0 : channels.is_force(c) ? 2 : 1;
    for (std::size_t k = 0; k < trials.size(); ++k) {
      const TrialResidual& trial = *trials[k];
      for (Eigen::Index begin = 0; begin < trial.residual.rows(); begin += bin) {
        double sum = 0.0;
        int count = 0;
        for (Eigen::Index f = begin; f < std::min<Eigen::Index>(begin + bin, trial.residual.rows()); ++f) {
          if (!std::isfinite(trial.residual(f, c))) continue;
          sum += trial.residual(f, c) - known.of(static_cast<Eigen::Index>(k), c, trial.load[f]);
          ++count;
        }
        if (2 * count < bin) continue;
        square[kind] += sum * sum / (count * errors.noise[c] * errors.noise[c]);
        bins[kind] += 1.0;
      }
    }
  }
  for (std::size_t kind = 0; kind < 3; ++kind) square[kind] = bins[kind] > 0.0 ? square[kind] / bins[kind] : 0.0;
  return square;
}

Eigen::VectorXd noise_seen(std::span<const RecordedTrial> trials, const Eigen::VectorXd& stated) {
  constexpr std::size_t kFewest = 60;
  constexpr double kMedianToDeviation = 1.4826;
  Eigen::VectorXd noise = stated;
  for (Eigen::Index c = 0; c < stated.size(); ++c) {
    std::vector<double> second;
    for (const RecordedTrial& trial : trials) {
      for (Eigen::Index f = 1; f + 1 < trial.seen.rows(); ++f) {
        const double value = trial.seen(f - 1, c) - 2.0 * trial.seen(f, c) + trial.seen(f + 1, c);
        if (std::isfinite(value)) second.push_back(std::abs(value));
      }
    }
    if (second.size() < kFewest) continue;
    const auto middle = second.begin() + static_cast<std::ptrdiff_t>(second.size() / 2);
    std::nth_element(second.begin(), middle, second.end());
    // A second difference of white noise has 1 + 4 + 1 times its variance. Less than half of what is stated is rather
    // a smoothed stream than a better device.
    noise[c] = std::max(0.5 * stated[c], kMedianToDeviation * *middle / std::sqrt(6.0));
  }
  return noise;
}

std::vector<const TrialResidual*> pointers_to(const std::vector<TrialResidual>& residuals, int but) {
  std::vector<const TrialResidual*> out;
  for (const TrialResidual& residual : residuals)
    if (residual.trial != but) out.push_back(&residual);
  return out;
}

ErrorModel raised(const ErrorModel& errors, const Channels& channels, const NormalEquations& equations) {
  const auto kind_of = [&channels](int c) { return channels.is_marker(c) ? 0 : channels.is_force(c) ? 1 : 2; };
  std::array<double, 3> square{}, count{};
  for (int c = 0; c < channels.count(); ++c) {
    square[kind_of(c)] += equations.chi_square_of_channel[c];
    count[kind_of(c)] += equations.count_of_channel[c];
  }
  ErrorModel out = errors;
  for (int c = 0; c < channels.count(); ++c) {
    const int kind = kind_of(c);
    if (square[kind] > count[kind]) out.noise[c] *= std::sqrt(square[kind] / count[kind]);
  }
  return out;
}

}  // namespace tissued::core
