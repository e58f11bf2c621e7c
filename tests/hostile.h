/* Macros that headers of others define, each as something that does not compile. For tests/hostile.sh: included after the system
   headers and before pktrt.h, whose own names must not be among them. */
#define HOSTILE 42 42

/* windows.h and what it includes; 16-bit keywords of old */
#define far HOSTILE
#define near HOSTILE
#define FAR HOSTILE
#define NEAR HOSTILE
#define huge HOSTILE
#define pascal HOSTILE
#define cdecl HOSTILE
#define PASCAL HOSTILE
#define CDECL HOSTILE
#define WINAPI HOSTILE
#define CALLBACK HOSTILE
#define small HOSTILE
#define hyper HOSTILE
#define interface HOSTILE
#define boolean HOSTILE
#define byte HOSTILE
#define IN HOSTILE
#define OUT HOSTILE
#define OPTIONAL HOSTILE
#define ERROR HOSTILE
#define NO_ERROR HOSTILE
#define DELETE HOSTILE
#define CONST HOSTILE
#define VOID HOSTILE
#define BOOL HOSTILE
#define TRUE HOSTILE
#define FALSE HOSTILE
#define THIS HOSTILE
#define PURE HOSTILE
#define STRICT HOSTILE
#define UNICODE HOSTILE
#define IGNORE HOSTILE
#define INFINITE HOSTILE
#define OPAQUE HOSTILE
#define TRANSPARENT HOSTILE
#define ABSOLUTE HOSTILE
#define RELATIVE HOSTILE
#define ALTERNATE HOSTILE
#define WINDING HOSTILE
#define UNALIGNED HOSTILE
#define DIFFERENCE HOSTILE
#define MAXCHAR HOSTILE
#define min(a, b) HOSTILE
#define max(a, b) HOSTILE
#define rad1 HOSTILE
#define rad2 HOSTILE
#define grp1 HOSTILE
#define grp2 HOSTILE
#define lst1 HOSTILE
#define psh1 HOSTILE
#define chx1 HOSTILE
#define edt1 HOSTILE
#define stc1 HOSTILE

/* X11 */
#define None HOSTILE
#define Bool HOSTILE
#define Status HOSTILE
#define Success HOSTILE
#define True HOSTILE
#define False HOSTILE
#define Always HOSTILE
#define Above HOSTILE
#define Below HOSTILE
#define Opposite HOSTILE
#define Complex HOSTILE
#define Convex HOSTILE
#define Nonconvex HOSTILE
#define Unsorted HOSTILE
#define CurrentTime HOSTILE
#define KeyPress HOSTILE
#define KeyRelease HOSTILE
#define Button1 HOSTILE
#define FocusIn HOSTILE
#define FocusOut HOSTILE
#define Expose HOSTILE
#define NoExpose HOSTILE
#define FillSolid HOSTILE
#define Absolute HOSTILE
#define Glyph HOSTILE
#define GrayScale HOSTILE
#define DirectColor HOSTILE
#define ControlMask HOSTILE
#define CursorShape HOSTILE

/* complex.h, math.h with extensions, tgmath.h */
#define I HOSTILE
#define complex HOSTILE
#define imaginary HOSTILE
#define DOMAIN HOSTILE
#define OVERFLOW HOSTILE
#define UNDERFLOW HOSTILE
#define SING HOSTILE
#define PLOSS HOSTILE
#define TLOSS HOSTILE
#define PI HOSTILE
#define log(x) HOSTILE
#define pow(x, y) HOSTILE
#define exp(x) HOSTILE
#define sin(x) HOSTILE
#define cos(x) HOSTILE
#define floor(x) HOSTILE
#define round(x) HOSTILE
#define abs(x) HOSTILE
#define fma(x, y, z) HOSTILE
#define fmin(x, y) HOSTILE
#define fmax(x, y) HOSTILE
#define fadd(x, y) HOSTILE
#define fsub(x, y) HOSTILE
#define fmul(x, y) HOSTILE
#define fdiv(x, y) HOSTILE
#define ffma(x, y, z) HOSTILE
#define dadd(x, y) HOSTILE
#define dsub(x, y) HOSTILE
#define dmul(x, y) HOSTILE
#define ddiv(x, y) HOSTILE
#define dsqrt(x) HOSTILE
#define dfma(x, y, z) HOSTILE
#define y0 HOSTILE
#define y1 HOSTILE
#define j0 HOSTILE
#define j1 HOSTILE
#define yn HOSTILE
#define jn HOSTILE
#define gamma HOSTILE

/* POSIX and others in a C library; some are defined already */
#undef unix
#undef linux
#undef NAME_MAX
#define unix HOSTILE
#define linux HOSTILE
#define major HOSTILE
#define minor HOSTILE
#define makedev HOSTILE
#define rindex HOSTILE
#define bzero HOSTILE
#define ECHO HOSTILE
#define B0 HOSTILE
#define B50 HOSTILE
#define CR1 HOSTILE
#define NL1 HOSTILE
#define VT1 HOSTILE
#define FF1 HOSTILE
#define PAGE_SIZE HOSTILE
#define NAME_MAX HOSTILE
#define st_atime HOSTILE
#define sa_handler HOSTILE
#define si_value HOSTILE
#define stdin_ HOSTILE
#define assert(x) HOSTILE
#define isdigit(x) HOSTILE
#define toupper(x) HOSTILE
#define getc(x) HOSTILE
#define putc(x, y) HOSTILE
#define send(a, b, c, d) HOSTILE
#define recv(a, b, c, d) HOSTILE
#define _A HOSTILE
#define _B HOSTILE
#define _C HOSTILE
#define _N HOSTILE
#define _P HOSTILE
#define _U HOSTILE
#define _X HOSTILE
#define _L HOSTILE
#define _S HOSTILE

/* curses.h */
#define box(a, b, c) HOSTILE
#define border(a, b) HOSTILE
#define clear() HOSTILE
#define move(y, x) HOSTILE
#define erase() HOSTILE
#define refresh() HOSTILE
#define timeout(x) HOSTILE
#define OK HOSTILE
#define ERR HOSTILE
#define COLS HOSTILE
#define LINES HOSTILE

/* Arduino and other small machines */
#define bit(x) HOSTILE
#define F(x) HOSTILE
#define sq(x) HOSTILE
#define radians(x) HOSTILE
#define degrees(x) HOSTILE
#define constrain(x, a, b) HOSTILE
#define lowByte(x) HOSTILE
#define DEFAULT HOSTILE
#define EXTERNAL HOSTILE
#define INTERNAL HOSTILE
#define HIGH HOSTILE
#define LOW HOSTILE
#define INPUT HOSTILE
#define OUTPUT HOSTILE
#define CHANGE HOSTILE
#define TWO_PI HOSTILE
#define EULER HOSTILE
#define SERIAL HOSTILE
#define DISPLAY HOSTILE
#define PINA HOSTILE
#define SP HOSTILE
#define R HOSTILE
#define G HOSTILE
#define B HOSTILE
#define N HOSTILE
#define D HOSTILE
#define E HOSTILE
#define K HOSTILE
#define L HOSTILE
#define M HOSTILE
#define T HOSTILE
#define U HOSTILE
#define V HOSTILE
#define W HOSTILE
#define X HOSTILE
#define Y HOSTILE
#define Z HOSTILE

/* Shading languages and vector libraries; short types; machines; <iso646.h>, whose names are words of C++ */
#define length HOSTILE
#define dot HOSTILE
#define normalize HOSTILE
#define reflect HOSTILE
#define refract HOSTILE
#define mix HOSTILE
#define clamp HOSTILE
#define lerp HOSTILE
#define saturate HOSTILE
#define fract HOSTILE
#define mod HOSTILE
#define vec2 HOSTILE
#define vec3 HOSTILE
#define vec4 HOSTILE
#define mat4 HOSTILE
#define norm HOSTILE
#define conj HOSTILE
#define real HOSTILE
#define imag HOSTILE
#define byte_ HOSTILE
#define word HOSTILE
#define dword HOSTILE
#define uint HOSTILE
#define ulong HOSTILE
#define uchar HOSTILE
#define u8 HOSTILE
#define u16 HOSTILE
#define u32 HOSTILE
#define u64 HOSTILE
#define i8 HOSTILE
#define i32 HOSTILE
#define f32 HOSTILE
#define f64 HOSTILE
#define exception HOSTILE
#define environ HOSTILE
#define event HOSTILE
#define test HOSTILE
#define loop HOSTILE
#define repeat HOSTILE
#define until HOSTILE
#define fail HOSTILE
#define expect HOSTILE
#define this_thread HOSTILE
#define nelem HOSTILE
#define elements HOSTILE
#define log2 HOSTILE
#undef i386
#define i386 HOSTILE
#undef mips
#define mips HOSTILE
#undef sparc
#define sparc HOSTILE
#undef sun
#define sun HOSTILE
#undef hpux
#define hpux HOSTILE
#undef PPC
#define PPC HOSTILE
#undef arm
#define arm HOSTILE
#ifndef __cplusplus
#define and HOSTILE
#define or HOSTILE
#define not HOSTILE
#define xor HOSTILE
#define compl HOSTILE
#define bitand HOSTILE
#define bitor HOSTILE
#define and_eq HOSTILE
#define or_eq HOSTILE
#define not_eq HOSTILE
#define xor_eq HOSTILE
#endif

/* What programs define themselves */
#define COUNT(array) HOSTILE
#define NAME HOSTILE
#define VOP HOSTILE
#define STEP HOSTILE
#define SMALL HOSTILE
#define SHARED HOSTILE
#define UNROLL HOSTILE
#define FRUSTUM_WIDTH HOSTILE
#define INSTANCE HOSTILE
#define MIN(a, b) HOSTILE
#define MAX(a, b) HOSTILE
#define CLAMP(x, a, b) HOSTILE
#define SWAP(a, b) HOSTILE
#define ABS(x) HOSTILE
#define EPSILON HOSTILE
#define DEBUG HOSTILE
#define NDEBUG HOSTILE
#define VERSION HOSTILE
#define PACKAGE HOSTILE
#define INLINE HOSTILE
#define EXPORT HOSTILE
#define UNUSED(x) HOSTILE
#define ARRAY_SIZE(x) HOSTILE
#define countof(x) HOSTILE
#define lengthof(x) HOSTILE
#define unused HOSTILE
#define noinline HOSTILE
#define always_inline HOSTILE
#define aligned(n) HOSTILE
#define packed HOSTILE
#define likely(x) HOSTILE
#define unlikely(x) HOSTILE
#define container_of(a, b, c) HOSTILE
#define foreach HOSTILE
#define forever HOSTILE
#define emit HOSTILE
#define signals HOSTILE
#define slots HOSTILE
#define var HOSTILE
#define elif_ HOSTILE
#define internal HOSTILE
#define global HOSTILE
#define local_persist HOSTILE
#define check(x) HOSTILE
#define verify(x) HOSTILE
#define require(x) HOSTILE
#define nil HOSTILE
#define Nil HOSTILE
#define YES HOSTILE
#define NO HOSTILE
