#pragma once

#include <string>

namespace tissued::tests {

// Two frames of three trajectories, one gap, two forces and what Nexus may put beside them.
inline const std::string kExport =
    "Devices\n"                                     // 1
    "100\n"                                         // 2
    ",,A1 - Force,,,Plate - CoP,,,A2 - Force,,\n"   // 3
    "Frame,Sub Frame,Fx,Fy,Fz,Cx,Cy,Cz,Fx,Fy,Fz\n"  // 4
    ",,N,N,N,mm,mm,mm,N,N,N\n"                      // 5
    "7,0,1.5,-2,3e-1,x,,,-0.001,0,4\n"              // 6
    "8,0,1.25,-2,0.5,,,,,,\n"                       // 7
    "\n"                                            // 8
    "Joints\n"                                      // 9
    "100\n"                                         // 10
    "whatever,1,2\n"                                // 11
    "\n"                                            // 12
    "Trajectories\n"                                // 13
    "100\n"                                         // 14
    ",,phantom:M01,,,bare,,,other:M01,,\n"          // 15
    "Frame,Sub Frame,X,Y,Z,X,Y,Z,X,Y,Z\n"           // 16
    ",,mm,mm,mm,cm,cm,cm,mm,mm,mm\n"                // 17
    "7,0,-0.116,0.029,60.078,1,2,3,9,9,9\n"         // 18
    "8,0,-0.112,-0.034,59.884,,,,8,8,8\n";          // 19

}  // namespace tissued::tests
