#pragma once

namespace tissued::daemon {

/// What a diagnosis adds to kPageStyle. It is dark on white everywhere: its pictures are made for that.
extern const char* const kDiagnosisStyle;

}  // namespace tissued::daemon
