#include "stability.h"

void suite_stability_accuracy(void) {}
