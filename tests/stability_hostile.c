#include "stability.h"

void suite_stability_hostile(void) {}
