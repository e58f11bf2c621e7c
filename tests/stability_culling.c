#include "stability.h"

void suite_stability_culling(void) {}
