// main of the test programs that work on volumes: with the heap of the program.
#include <gtest/gtest.h>

#include "segmentation/volume/held_memory.hpp"

int main(int argc, char** argv) {
  borelli::hold_freed_memory();
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
