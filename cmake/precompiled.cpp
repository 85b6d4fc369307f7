// SPDX-License-Identifier: BSD-2-Clause
// Empty on purpose: CMake compiles precompiled headers beside the sources of a target (precompiled.cmake).
