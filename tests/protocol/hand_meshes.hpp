#pragma once

#include <string>

namespace tissued::tests {

// Two tetrahedra over the corner of a cube of 10 mm, written by hand from the formats' manuals: the same mesh thrice,
// with the surface groups base (one triangle) and skin (two).

inline const std::string kGmsh2 =
    "$MeshFormat\n"          // 1
    "2.2 0 8\n"              // 2
    "$EndMeshFormat\n"       // 3
    "$PhysicalNames\n"       // 4
    "3\n"                    // 5
    "2 21 \"base\"\n"        // 6
    "2 22 \"skin\"\n"        // 7
    "3 31 \"tissue\"\n"      // 8
    "$EndPhysicalNames\n"    // 9
    "$Nodes\n"               // 10
    "5\n"                    // 11
    "7 0 0 0\n"              // 12
    "3 10 0 0\n"             // 13
    "4 0 1e1 0\n"            // 14
    "90 0 0 10.0\n"          // 15
    "5 10 10 10\n"           // 16
    "$EndNodes\n"            // 17
    "$Elements\n"            // 18
    "7\n"                    // 19
    "1 15 2 0 1 7\n"         // 20
    "2 1 2 0 1 7 3\n"        // 21
    "3 2 2 21 1 7 4 3\n"     // 22
    "4 2 2 22 2 3 4 5\n"     // 23
    "6 2 2 22 2 4 90 5\n"    // 24
    "8 4 2 31 1 7 3 4 90\n"  // 25
    "9 4 2 31 1 3 4 90 5\n"  // 26
    "$EndElements\n";        // 27

inline const std::string kGmsh4 =
    "$MeshFormat\n"                  // 1
    "4.1 0 8\n"                      // 2
    "$EndMeshFormat\n"               // 3
    "$PhysicalNames\n"               // 4
    "3\n"                            // 5
    "2 21 \"base\"\n"                // 6
    "2 22 \"skin\"\n"                // 7
    "3 31 \"tissue\"\n"              // 8
    "$EndPhysicalNames\n"            // 9
    "$Entities\n"                    // 10
    "1 1 2 1\n"                      // 11
    "1 0 0 0 0\n"                    // 12
    "1 0 0 0 10 0 0 0 2 1 -2\n"      // 13
    "1 0 0 0 10 10 0 1 21 1 1\n"     // 14
    "2 0 0 0 10 10 10 1 22 0\n"      // 15
    "1 0 0 0 10 10 10 1 31 2 1 2\n"  // 16
    "$EndEntities\n"                 // 17
    "$Nodes\n"                       // 18
    "3 5 3 90\n"                     // 19
    "2 1 0 2\n"                      // 20
    "7\n"                            // 21
    "3\n"                            // 22
    "0 0 0\n"                        // 23
    "10 0 0\n"                       // 24
    "2 2 1 1\n"                      // 25
    "4\n"                            // 26
    "0 10 0 0.5 0.5\n"               // 27
    "3 1 0 2\n"                      // 28
    "90\n"                           // 29
    "5\n"                            // 30
    "0 0 10\n"                       // 31
    "10 10 10\n"                     // 32
    "$EndNodes\n"                    // 33
    "$Elements\n"                    // 34
    "5 7 1 9\n"                      // 35
    "0 1 15 1\n"                     // 36
    "1 7\n"                          // 37
    "1 1 1 1\n"                      // 38
    "2 7 3\n"                        // 39
    "2 1 2 1\n"                      // 40
    "3 7 4 3\n"                      // 41
    "2 2 2 2\n"                      // 42
    "4 3 4 5\n"                      // 43
    "6 4 90 5\n"                     // 44
    "3 1 4 2\n"                      // 45
    "8 7 3 4 90\n"                   // 46
    "9 3 4 90 5\n"                   // 47
    "$EndElements\n";                // 48

inline const std::string kTetgenNode =
    "# five points\n"             // 1
    "5 3 1 1\n"                   // 2
    "\n"                          // 3
    "0  0 0 0  0.5 1\n"           // 4
    "1  10 0 0  0.5 1 # right\n"  // 5
    "2  0 10 0  0.5 0\n"          // 6
    "3  0 0 10  0.5 0\n"          // 7
    "4  10 10 10  0.5 0\n";       // 8

inline const std::string kTetgenEle =
    "2 4 1\n"           // 1
    "0  0 1 2 3  31\n"  // 2
    "1  1 2 3 4  31\n"  // 3
    "# Generated\n";    // 4

inline const std::string kTetgenFace =
    "3 1\n"            // 1
    "0  0 2 1  21\n"   // 2
    "1  1 2 4  22\n"   // 3
    "2  2 3 4  22\n";  // 4

}  // namespace tissued::tests
