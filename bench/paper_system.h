/* paper_system.h - parts of paper.c that are about the system: sections 3.1 and 6, frame rates, peers. */
