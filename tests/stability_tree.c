#include "stability.h"

void suite_stability_tree(void) {}
