#include "config/geometry.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>
#include <sstream>

namespace tissued::config {
namespace {

constexpr double kTolerance = 1e-3;

std::string shown(double number) {
  std::ostringstream text;
  text << number;
  return text.str();
}

}  // namespace

core::Vec3 to_vector(const Json& numbers) {
  return {numbers[0].get<double>(), numbers[1].get<double>(), numbers[2].get<double>()};
}

core::Vec3 to_unit_vector(const Document& document, const JsonPointer& key) {
  const Json& numbers = document.root().at(key);
  const core::Vec3 vector = to_vector(numbers);
  if (!(std::abs(vector.norm() - 1.0) <= kTolerance)) {
    document.refuse(key, quoted(numbers) + " is not a unit vector: its length is " + shown(vector.norm()) + ", not 1");
  }
  return vector.normalized();
}

core::Mat3 to_rotation(const Document& document, const JsonPointer& key) {
  const Json& rows = document.root().at(key);
  core::Mat3 matrix;
  for (int row = 0; row < 3; ++row) matrix.row(row) = to_vector(rows[static_cast<std::size_t>(row)]);
  const double skew = (matrix * matrix.transpose() - core::Mat3::Identity()).cwiseAbs().maxCoeff();
  if (!(skew <= kTolerance)) {
    document.refuse(key, quoted(rows) + " is not a rotation: its rows are off orthonormal by " + shown(skew) +
                             ", more than " + shown(kTolerance));
  }
  if (matrix.determinant() < 0.0) {
    document.refuse(key, quoted(rows) + " is not a rotation but a reflection: its determinant is -1, not 1");
  }
  const Eigen::JacobiSVD<core::Mat3> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

}  // namespace tissued::config
