#pragma once

#include "config/document.hpp"
#include "core/types.hpp"

namespace tissued::config {

// Three numbers that have passed their schema.
core::Vec3 to_vector(const Json& numbers);

// A direction, scaled to length 1; refused where it is off by more than 1e-3.
core::Vec3 to_unit_vector(const Document& document, const JsonPointer& key);

// A rotation matrix by rows; refused where it is not orthonormal with determinant 1 to 1e-3. What is handed out is the
// nearest rotation.
core::Mat3 to_rotation(const Document& document, const JsonPointer& key);

}  // namespace tissued::config
