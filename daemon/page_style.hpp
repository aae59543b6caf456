#pragma once

namespace tissued::daemon {

/// The style sheet of the evaluation's page: light, dark and print. Series take the colours of Okabe and Ito, which
/// colour-blind readers can tell apart, made lighter for the dark.
extern const char* const kPageStyle;

}  // namespace tissued::daemon
