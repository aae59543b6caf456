// What Tagliabue et al. print in "Position-based modeling of lesion displacement in ultrasound-guided breast biopsy",
// section 3. Its figures 6 and 7 are drawn from its Table 3, but for the rigid model, which comes without numbers.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

namespace tissued::daemon::tagliabue {

/// Table 2: shape-matching clusters as calibrated, and the error of lesion 1 with them, mm.
struct Calibrated {
  const char* phantom;
  double cluster_spacing, cluster_radius;  ///< mm
  double cluster_stiffness;
  double mean_error, std_error;  ///< mm
};
inline constexpr std::array<Calibrated, 2> kTable2{{{"calibration phantom", 9.6001, 9.1674, 0.452390, 6.64, 2.00},
                                                    {"breast phantom", 11.1626, 8.5424, 0.464890, 5.07, 1.62}}};

/// A range of pushes that Table 3 puts together, mm: low <= push < high.
struct PushRange {
  const char* name;
  double low, high;
};
inline constexpr std::array<PushRange, 5> kRanges{
    {{"D10", 0.0, 12.5}, {"D15", 12.5, 17.5}, {"D20", 17.5, 22.5}, {"D25", 22.5, 27.5}, {"D30", 27.5, 1e9}}};

/// Table 3: mean localization error, mm, by lesion and range; NaN where it prints a dash.
inline constexpr std::size_t kLesions = 10;
using LesionErrors = std::array<std::array<double, kRanges.size()>, kLesions>;
inline constexpr double kDash = std::numeric_limits<double>::quiet_NaN();
inline constexpr LesionErrors kPbd{{{kDash, 3.259, 3.724, 5.307, 6.214},
                                    {1.467, 4.475, 6.700, kDash, 8.347},
                                    {3.689, kDash, 5.590, 7.831, 11.930},
                                    {5.141, 6.011, 5.396, 5.684, kDash},
                                    {2.190, 2.018, 4.501, kDash, 6.694},
                                    {5.644, 4.319, 3.735, kDash, 3.982},
                                    {2.810, 3.961, 6.374, 10.636, kDash},
                                    {5.581, 5.659, 6.120, 6.683, kDash},
                                    {kDash, 4.506, 3.833, 4.007, 4.511},
                                    {4.606, 2.990, 3.193, 3.774, kDash}}};
inline constexpr LesionErrors kFiniteElements{{{kDash, 2.686, 2.495, 3.626, 5.175},
                                               {3.621, 5.964, 5.804, kDash, 7.087},
                                               {3.793, kDash, 6.952, 8.136, 9.646},
                                               {4.142, 3.886, 4.954, 4.822, kDash},
                                               {1.255, 1.275, 1.590, kDash, 3.758},
                                               {6.581, 5.871, 6.410, kDash, 6.671},
                                               {5.462, 5.614, 6.414, 10.768, kDash},
                                               {6.983, 4.835, 4.874, 5.418, kDash},
                                               {kDash, 5.032, 5.277, 5.047, 6.503},
                                               {2.682, 2.831, 3.341, 2.966, kDash}}};

/// s to follow one push, section 3.2.
inline constexpr double kPbdTime = 1.75;
inline constexpr double kFiniteElementTime = 4.09;
inline constexpr int kTetrahedra = 26220;  // of its finite elements

/// The bundles that repeat its calibration block and its breast; the landmark of both is the first target.
inline constexpr const char* kBlockName = "gel";
inline constexpr const char* kBreastName = "cirs";

}  // namespace tissued::daemon::tagliabue
