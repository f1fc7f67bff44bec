#pragma once

#include <petscsnes.h>

/// What a scene is solved with unless its options say otherwise. Before SNESSetFromOptions(), but
/// for the last two.
namespace trefoil {

/// Of the plugin, in every scene.
PetscErrorCode set_program_defaults(SNES snes);
/// Of a scene's SNES, those of the plugin included.
PetscErrorCode set_defaults(SNES snes);
/// Then of steps in time: each starts where the last one ended, near its own end, and a direction
/// that is small enough is followed all the same.
PetscErrorCode set_time_defaults(SNES snes);
/// After SNESSetFromOptions(): SNES types and line searches that know nothing of our tests end a
/// step in time by the residual, against that at its start, or by steps that are nothing beside
/// what the body has moved.
PetscErrorCode set_time_tests_of_others(SNES snes);

}  // namespace trefoil
