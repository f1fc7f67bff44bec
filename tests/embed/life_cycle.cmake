# One process that starts and ends PETSc several times, with hosts of every kind; nothing of theirs
# or ours may be left at an end.
add_executable(life_cycle ${CMAKE_CURRENT_LIST_DIR}/life_cycle.c)
target_link_libraries(life_cycle PRIVATE libtrefoil m)
target_compile_options(life_cycle PRIVATE -Wall -Wextra -Wno-unused-parameter)
set_target_properties(life_cycle PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
foreach(ranks 1 2)
  add_test(NAME life_cycle_on_${ranks}
    COMMAND ${MPIEXEC_EXECUTABLE} ${MPIEXEC_NUMPROC_FLAG} ${ranks} $<TARGET_FILE:life_cycle>
      -library $<TARGET_FILE:libtrefoil> -malloc_dump -options_left)
  set_tests_properties(life_cycle_on_${ranks} PROPERTIES
    PASS_REGULAR_EXPRESSION "all life cycles have ended"
    FAIL_REGULAR_EXPRESSION "[0-9] bytes ;Option left;unused database option;PETSC ERROR"
    TIMEOUT 300 ENVIRONMENT "OPENBLAS_NUM_THREADS=1;OMP_NUM_THREADS=1")
endforeach()
