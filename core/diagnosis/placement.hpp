// What it does to a prediction that markers sit elsewhere than the scene has them: not only are they seen off by as
// much, they ride on another spot of the skin, which near a pad moves by tenths of a millimetre more or less.
#pragma once

#include <span>
#include <vector>

#include "core/diagnosis/likelihood.hpp"
#include "core/diagnosis/load_path.hpp"

namespace tissued::core {

struct Placement {
  // (trials) (keys x 9 markers): of a marker's displacement by its place, columns 9 m + 3 j + i for component i by
  // place j; by quadratic elements with the scene's numbers. Zero in trials without an equilibrium, and of markers at
  // the edge of where the scene's checks let them be.
  std::vector<RowMatrix> slopes;
  // (trials x 3 markers) mm, standard deviation at the peak of the load: what such a slope does not tell, because it
  // changes over the offset, and because elements of that size do not know it well.
  RowMatrix doubt;
};

// offset: mm per axis, standard deviation, to which markers are placed.
Placement placement_of(const Scene& scene, std::span<const LoadPath> paths, double offset);

// Takes off the residuals of markers what their place accounts for, as far as it shows: the offset that is most likely
// given the residuals, times the slopes.
void take_off_placement(const ErrorModel& errors, const Channels& channels, std::span<const LoadPath> paths,
                        std::span<const RowMatrix> slopes, const std::vector<RecordedTrial>& trials,
                        std::vector<TrialResidual>& residuals);

// Likewise off the derivatives of markers by one parameter: of what moves all markers at once, as a misregistration,
// the most likely offset takes a part, and with it what that does.
void take_off_placement(const ErrorModel& errors, const Channels& channels, std::span<const LoadPath> paths,
                        std::span<const RowMatrix> slopes, const std::vector<RecordedTrial>& trials,
                        std::vector<TrialResidual>& residuals, std::size_t parameter);

}  // namespace tissued::core
