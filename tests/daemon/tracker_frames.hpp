#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "core/types.hpp"
#include "protocol/tracker_frame.hpp"

// Tracker frames in one line each.
inline tissued::protocol::Name name_of(const std::string& text) { return tissued::protocol::Name::from(text).value(); }

inline std::array<double, 3> array_of(const tissued::core::Vec3& v) { return {v.x(), v.y(), v.z()}; }

struct FrameBuilder {
  tissued::protocol::TrackerFrame frame;

  explicit FrameBuilder(std::uint32_t number) {
    frame.frame_number = number;
    frame.receive_ns = number * std::uint64_t{10'000'000};
  }
  FrameBuilder& stamp(std::uint64_t ns) {
    frame.stamp_ns = ns;
    return *this;
  }
  FrameBuilder& received(std::uint64_t ns) {
    frame.receive_ns = ns;
    return *this;
  }
  FrameBuilder& marker(const std::string& name, const tissued::core::Vec3& position, bool occluded = false) {
    frame.markers.push_back({name_of(name), array_of(position), occluded});
    return *this;
  }
  FrameBuilder& pad(const std::string& name, const tissued::core::Vec3& position,
                    const std::array<double, 3>& rotation_rad = {}) {
    frame.objects.push_back({name_of(name), array_of(position), rotation_rad});
    return *this;
  }
  FrameBuilder& force(const std::string& name, const tissued::core::Vec3& force) {
    frame.forces.push_back({name_of(name), array_of(force)});
    return *this;
  }
  FrameBuilder& truth(const std::string& name, const tissued::core::Vec3& position) {
    frame.truth.push_back({name_of(name), array_of(position)});
    return *this;
  }
  FrameBuilder& completion(tissued::protocol::FrameCompletion completion) {
    frame.completion = completion;
    return *this;
  }
  FrameBuilder& after_restart() {
    frame.after_restart = true;
    return *this;
  }
};

// M1 of the small scene moved by `shift` mm along x, and nothing else: the fake simulator moves everything as much.
inline FrameBuilder frame_with_shift(std::uint32_t number, double shift) {
  FrameBuilder builder(number);
  builder.stamp(number * std::uint64_t{10'000'000}).marker("M1", tissued::core::Vec3(shift, 0, 40));
  return builder;
}
