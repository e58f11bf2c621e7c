/* pktrt.h - v0.15.6 - packet ray tracing in one C header: queries, for one ray or for millions, and pictures

   After Boulos, Edwards, Lacewell, Kniss, Kautz, Shirley and Wald, "Packet-based Whitted and Distribution Ray Tracing",
   Graphics Interface 2007. MIT or public domain, at your choice (>>licence, at the end of the file).

   Do this in exactly one file of your program, which thereby holds the implementation:

       #define PKTRT_IMPLEMENTATION
       #include "pktrt.h"

   and include it without the define wherever else you need it. It compiles as C99 and later and as C++11 and later; a
   plain `cc -O2 file.c -lm` uses the widest vectors of the machine it runs on. The API stands first and is short: read
   on from DECLARATIONS to "stop here if you only want the API", and come back here when you want to know why.


   QUICK START (compiles as is)

     #define PKTRT_IMPLEMENTATION // in exactly one file of a program
     #include "pktrt.h"
     #include <math.h>
     #include <stdio.h>

     enum { WIDTH = 72, HEIGHT = 36 };
     static float pixels[HEIGHT][WIDTH][3]; // linear RGB, row 0 at the top

     int main(void) {
       static const float floor_xyz[] = {-9, 0, -9, -9, 0, 9, 9, 0, 9, 9, 0, -9};
       static const float pyramid_xyz[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1, 0, 1.5f, 0};
       static const uint32_t floor_triangles[] = {0, 1, 2, 0, 2, 3};
       static const uint32_t pyramid_triangles[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
       static pktrt_mesh_desc ground, pyramid; // static, hence zeroed: what is not set is a sensible default
       ground.positions = floor_xyz, ground.vertex_count = 4;
       ground.indices = floor_triangles, ground.triangle_count = 2;
       pyramid.positions = pyramid_xyz, pyramid.vertex_count = 5;
       pyramid.indices = pyramid_triangles, pyramid.triangle_count = 4;
       static pktrt_light sun;
       sun.kind = PKTRT_LIGHT_DIRECTIONAL;
       sun.direction[0] = -4, sun.direction[1] = -2.5f, sun.direction[2] = -1;
       sun.intensity[0] = sun.intensity[1] = sun.intensity[2] = 3;

       pktrt_scene *scene = pktrt_scene_create(NULL);
       if (!scene || pktrt_add_mesh(scene, &ground, NULL) || pktrt_add_mesh(scene, &pyramid, NULL) ||
           pktrt_add_light(scene, &sun, NULL) || pktrt_commit(scene))
         return printf("%s\n", pktrt_last_error(scene)), 1;

       const pktrt_ray ray = {{0.1f, 5, 0.2f}, 0, {0, -1, 0}, INFINITY, 0}; // origin, tmin, direction, tmax, time
       pktrt_hit hit;
       if (pktrt_intersect(scene, &ray, &hit))
         printf("mesh %u, triangle %u, t = %g\n", (unsigned)hit.mesh, (unsigned)hit.triangle, (double)hit.t);

       static pktrt_render_desc view;
       view.width = WIDTH, view.height = HEIGHT, view.pixels = &pixels[0][0][0];
       view.camera.eye[0] = 2, view.camera.eye[1] = 2, view.camera.eye[2] = 4;
       view.camera.target[1] = 0.4f, view.camera.fov_y = 32;
       view.ambient[0] = 0.15f; // this picture needs one channel only
       if (pktrt_render(scene, &view)) return printf("%s\n", pktrt_last_error(scene)), 1;
       for (int y = 0; y < HEIGHT; y += 2) // a character is twice as high as wide
         for (int x = 0; x < WIDTH; x++) {
           const float v = pixels[y][x][0] * 12;
           printf("%c%s", " .,:-=+ox%#@"[v < 11 ? (int)v : 11], x + 1 < WIDTH ? "" : "\n");
         }
       pktrt_scene_destroy(scene);
       return 0;
     }

   END OF QUICK START

   It prints what one ray hits (mesh 1, triangle 1, t = 3.8) and 72 x 18 characters: a pyramid with its shadow.


   CONTENTS: search for these tags to walk through the file

     Declarations
       >>types        enumerations: instruction sets, build quality, traversal paths, ray types
       >>errors       status codes, and the sentence that says what was wrong
       >>hooks        allocator, parallel_for, log; creating a scene
       >>mesh         adding, committing, deforming and refitting meshes; what a scene is made of
       >>instance     models, and instances that place them
       >>query        rays, hits, one or many, arrays of structures or structures of arrays; leaving a surface
       >>stats        counts of work, events for teaching, queries with everything spelled out
       >>tree         the trees, to look at
       >>report       what a scene has, what a render runs, and what was left out
       >>camera       a pinhole or a thin lens, a shutter, between two poses
       >>light        point, directional, quad, sphere, mesh, environment; which light is counted where
       >>material     diffuse, mirror, coat, glass, metal; Phong lobes; hooks for textures and shaders
       >>sampler      seven sets of samples, and the mappings from the unit square
       >>render       pictures, and all that can be chosen about them

     Read these two before the code
       >>life         the life of a ray: the functions it passes, and what holds it on its way
       >>extend       how to add a light, a material, a sampler, an instruction set, a feature

     Implementation, compiled once
       >>platform     compilers, instruction sets of this build, the guard against flags that change values
       >>limits       constants: depth, stack
       >>structures   nodes, leaf blocks, meshes, trees, the scene
       >>memory       the one way to the allocator hooks
       >>basics       bits, conversions, minimum and maximum, hash
       >>build        the tree: binary by surface area, then 8-wide, then bounds
       >>refit        bounds after deformation
       >>validate     what is refused, and in which words
       >>commit       all or nothing
       >>exactness    THE definition of a hit, and the bound of every culling test: read this one
       >>exact        the canonical test itself
       >>batch        rays as the kernels see them
       >>places       how instances lie, and rays in their frames
       >>random       what samples are made of: permutations, scrambling, Sobol's points
       >>kinds        materials, lights and samplers, a row for each
       >>waves        rays and surfaces as the renderer sees them
       >>kernels      what an instruction set offers: the table of its kernels
       >>check        arithmetic that is not what the code asks for
       >>stamping     this file includes itself, once per instruction set

     Implementation, stamped once for each instruction set
       >>ops          vectors: the only place where instruction sets differ
       >>names        the kernels' names
       >>setup        from a ray to what traversal needs of it
       >>triangles    filter, canonical test, acceptance
       >>boxes        slabs
       >>frustum      four planes around up to 64 rays, which cull nodes and triangles for all of them
       >>leaves       rays and packets at leaf blocks; what a bench may put other tests in place of
       >>single       one ray: nearest child first, or any hit
       >>stream       up to 64 rays that share nodes and stack, each with the work of a single ray
       >>packets      frustum packets through the tree
       >>paper        the paper's packets, plain: the place to begin reading
       >>drive        from many rays to packets, streams and single rays
       >>resolve      u, v and normal, once for each ray
       >>shade        surfaces, scattering and shadow rays, eight at a time
       >>fit          blocks and nodes of builds and refits
       >>instances    rays at the top level, and in the models there
       >>entry        one batch of rays
       >>arrays       arrays of structures to batches and back
       >>selftest     what the compiler made of the vectors
       >>table        the kernels of this instruction set

     Implementation of the public functions
       >>dispatch     the choice of kernels at run time
       >>scene        meshes, lights and materials come and change
       >>queries      batches out of arrays, and back
       >>spawn        how far a ray starts from the surface it leaves
       >>crossings    all hits along a ray; whether a point is inside
       >>vectors      the few operations that are not done by eights
       >>shading      what one shades with: normals, texture coordinates; rays from points of triangles
       >>samplers     the sets
       >>elementary   exp, log, sine and cosine, the same on every machine
       >>mappings     from the unit square to disk, sphere, hemisphere and lobe
       >>fresnel      how much is reflected
       >>lens         the camera
       >>request      checks of a render, and what it needs
       >>lights       what is known of lights before the first ray, and points on them
       >>glass        where it is, for shadow rays
       >>media        which glasses a ray is in
       >>workspace    what a tile needs
       >>surfaces     what the rays of a wave met
       >>materials    textures, shaders, weights of what is reflected and refracted
       >>assembly     how rays are put together to packets (paper 3.2)
       >>direct       direct light
       >>scattering   the rays of the next generation
       >>generations  the recursion, packet by packet
       >>tiles        samples, pixels, blocks
       >>passes       rounds of tiles; what passes know of their error, and who gets the next
       >>rendering    checks, warnings, and pktrt_render itself  
       >>reporting    the scene report and its text
       >>changes      what came with which version
       >>licence      MIT or public domain

   WHAT IT DOES NOT DO

   - No window, no files, no threads of its own: pictures are arrays of floats, threads come through parallel_for.
   - No any-hit filters in queries: pktrt_intersect_after goes on from a hit. Triangles only; models have no instances, and
     instances no lights; pictures see all masks.
   - Pictures are ray traced after Whitted and Cook, not path traced: no light from diffuse surface to diffuse surface
     (an ambient constant and an environment light stand for it), and no caustics.
   - MSVC is untested. gcc, clang, tcc, MinGW and emscripten are, on 32 and 64 bits, little-endian and big-endian.


   CONFIGURATION: define before including the header

     PKTRT_IMPLEMENTATION     This file holds the implementation. Let it hold nothing else: compiling it takes ten
                              seconds with optimisation, which an edit of your own code need not cost. The macros below
                              matter in that file alone.
     PKTRT_STATIC             Beside PKTRT_IMPLEMENTATION: all functions are static, a private copy for this file.
                              Define it before the file's first #include of the header.
     PKTRT_DEF                What stands before every function, as __declspec(dllexport) or
                              __attribute__((visibility("default"))). Default: extern. Define it before the file's first
                              #include, and not beside PKTRT_STATIC. Functions are extern "C" in C++ in any case.
     PKTRT_HEADER_FILENAME    How the file names itself, for the implementation includes itself once per instruction
                              set. Default: "pktrt.h". Define it, quotes and all, if you rename the file.
     Instruction sets. Each one that is left out makes the object smaller and its compilation faster.
     PKTRT_NO_SIMD            Scalar kernels only.
     PKTRT_NO_SCALAR, _SSE2, _AVX2, _AVX512
                              None of that set. What remains must suit the machine, or no scene can be created.

     Parts. What is left out takes no code; pictures and hits of what stays are the same bits. Whatever asks for such a
     part is refused, in a sentence that names its switch. A scene that has not got a part does not run its code anyway:
     these are for programs that never will. pktrt_get_scene_report tells what a scene has.
     PKTRT_NO_RENDER          Queries only: no pictures, lights, materials, samplers. Nothing of it is declared. As the
                              next one, define it before the file's first #include.
     PKTRT_NO_NORMALS         Shading normals are not kept; pktrt_set_normals is not declared.
     PKTRT_NO_MOTION          Meshes have one key, cameras stand still.
     PKTRT_NO_INSTANCES       No models and instances; what is declared for them is not. Define it before the file's
                              first #include, too.
     PKTRT_NO_GROUPS          No groups and masks of meshes and instances, no masks of queries.
     PKTRT_NO_REMOVAL         Meshes and instances stay, and are seen; what would remove or hide them is not declared.
                              Define it before the file's first #include, too.
     PKTRT_NO_SURFACES        No texture coordinates, no cutouts; pktrt_surface and pktrt_spawn_at are not declared.
                              Define it before the file's first #include, too.
     PKTRT_NO_STATS           No counts of work, no events of the paper's path.
     PKTRT_NO_PAPER           Not the paper's path.
     PKTRT_NO_FRUSTA          The fast path has streams, but no frustum packets: coherent rays take longer.
     PKTRT_NO_LENS, PKTRT_NO_SHUTTER
     PKTRT_NO_AREA_LIGHTS     No quads, spheres, meshes or environment as lights.
     PKTRT_NO_GLOSS           No Phong lobes.
     PKTRT_NO_DIELECTRIC, PKTRT_NO_CONDUCTOR
                              No glass, no metal.
     PKTRT_NO_TEXTURES        No texture or shader hooks of materials.


   CONCEPTS

   Scene. Meshes are copied in; pktrt_commit builds trees over them. Changes of meshes wait until the next commit or
   refit; until then queries see the last committed state (none yet: every ray misses), and a failed commit keeps it.
   Lights and materials count from the next render on.

   Trees. All meshes of one group with the same number of motion keys and one mask share a tree: static ones never pay
   for moving ones, and commit rebuilds only trees that changed. A ray visits every tree: give moving meshes equal key
   counts if you can. Instances show a model, a set of meshes with trees of its own, wherever a matrix places it; above
   them is one tree more, of their boxes. To move one costs what that tree costs, not what the models and all else do.

   Groups. What is built once and what comes, goes or deforms should not share a tree: give the latter groups, one for
   what changes together. Up to four trees of groups are visited one after the other; more have a tree above them, and
   rays are then traced in streams there, without frusta. Masks let queries choose meshes, at the price of a tree for each
   mask that occurs: a few kinds of things, not a thing each.

   Motion keys. A mesh with K keys has K sets of positions, evenly spread over time [0,1]; every ray has its own time,
   and vertices move along straight lines from key to key. The boxes of the tree have K keys too and are interpolated to
   the ray's time: a fast mover has a small box at any moment, not a large one at all times.

   Packet. Neighbouring rays that are traced together through the tree, so that they share its nodes and, better, are
   spared most of the tests. They need no common origin: reflections and shadows qualify as well as camera rays.

   First active ray, active range (paper path). A packet remembers its first ray that may still hit something:

       rays            0  1  2  3  4  5  6  7  ...  63
       missed above    -  -  -
       first active             ^  tests the next box; if it hits, all from here on go down for the price of one test

   Those behind it that miss the box come along, though no farther than the last group known to hit; at a leaf they are
   tested against its box once more before any triangle. What is tested in vain is wasted, never wrong.

   Interval ray (paper path). If the first active ray misses, one test in interval arithmetic (origins, directions,
   depths and times of the whole packet as intervals) asks whether any ray at all can hit the box.

   Frustum. Four planes around all rays of a packet. A box outside one of them is missed by all, whatever their number.
   In the paper path it needs a common origin; the fast path takes the hull of the rays' positions at two depths.

   Mask stream (fast path). Up to 64 rays of one octant of directions walk the tree together, and each stack entry
   carries a mask of the rays concerned. Every ray does the work it would do alone; what they share is loading nodes,
   sorting children and the stack. This serves rays that no frustum can hold, and packets that have become thin.

   When culling wins and when it loses. A packet pays off while its rays meet the same boxes: camera rays, shadow rays
   towards one light, mirror reflections off flat or gently curved things; the denser the rays against the triangles,
   the more. It loses, to the point of costing far more than single rays, where rays diverge: diffuse bounces, ambient
   occlusion, tiny triangles under few rays, large packets at the silhouettes of small things. Tests for each primary
   ray in the pool hall (example render.c, about 318,000 triangles, 512 x 512 pixels; one test of a whole packet is not
   in these counts, and a single ray tests eight boxes at once):

                                       boxes    triangles
       single rays                      121        12
       fast path (8 x 8 pixels)          24         8
       paper path, 8 x 8 pixels          29        13
       paper path, 16 x 16 pixels        28        13

   Pictures. Three kinds, as in the paper. RCS casts primary and shadow rays. WRT (Whitted 1980) follows reflection and
   refraction, and branches at glass. DRT (Cook 1984) takes many samples of each pixel, of the lens, the time, the
   lights and the lobes, and at glass chooses one of the two ways by Fresnel weight: N rays in, N rays out.

   Waves. The rays of a packet (fast path: of several) are one wave. What they meet is gathered into a dense list of
   surfaces, which are shaded eight at a time; their shadow rays are traced; the rays that they reflect and refract
   form the waves of the next generation, which bring their radiance back to the surfaces that sent them. So a sample's
   sum is taken along its ray tree, own light first, then reflection, then refraction, whatever rays share a packet.

   Passes. A render may be made of several complete sets of samples, each scrambled independently of the others: their
   scatter tells how wrong the mean is, for a pixel, a block and the picture, which no set can tell of itself. So a
   render can end when an error is reached, or a time, and its passes can go where the error is. The picture is whole
   after each. One large set is better than several small ones: two of N / 2 samples err up to 1.35 times as much as one
   of N where all is smooth, and hardly more where edges and many dimensions decide. Ask for errors with few, large
   passes; ask for a target with small ones (8 samples, say).

   Assembly. What may share a packet (paper 3.2): all rays of one type (default), runs of neighbours on one material,
   groups by material or by octant of directions, all blindly, or none. It changes speed, not pixels.

   You need not choose. pktrt_intersect_n and its kin look at the rays in fours of 64: those that look one way become
   frustum packets, others go by octant into streams, and a packet that thins out to 16 rays, or 8 at a leaf (up to twice
   as many where origins differ or any hit will do, and 16 and 8 more where things move), becomes a stream on its way
   down. Fewer than 16 rays of a call (32 for occlusion) go one by one. Order helps: neighbours in space, such as 8 x 8
   pixels, next to each other, shadow rays of each light apart.


   CONVENTIONS

   - Right-handed, as far as it matters: the camera looks along target - eye with x to the right and y up.
   - Triangles are hit from both sides. The normal of a hit is along cross(p1 - p0, p2 - p0): it points to where the
     corners appear counter-clockwise. It is not of unit length; its largest component is 1 or -1. Shading turns it to
     the viewer.
   - Directions have any length, and t counts in it: point = origin + t direction. Hits are those with tmin < t < tmax.
     For a shadow ray let the direction reach from point to light, and tmax be 1.
   - Barycentrics: point = (1 - u - v) p0 + u p1 + v p2. From it you get the point more precisely than from t.
   - Time: 0 is the first key, 1 the last. Outside it is clamped, NaN counts as 0. Static scenes ignore it.
   - Units of length are yours. Radiance is intensity cos / (pi r^2) for a point light, see >>light. Refraction does not
     scale radiance by the square of the index, as it would between media: what enters glass leaves it again. Colours
     are linear RGB: before an 8-bit screen sees them, apply its curve (sRGB). Row 0 of a picture is the top one.


   GUARANTEES

   Exactness. Rays and vertices are taken at their word, as real numbers: the triangle that is hit is the one that exact
   arithmetic names, at any scale and angle, and t is within 0.7 ulp of the exact one; u and v within 2^-23, the normal's
   direction within 2^-22. Each crossing of a closed surface belongs to exactly one triangle, at shared edges and vertices
   too, if these have the same coordinates bit for bit and the same number of keys: nothing leaks, nothing is counted
   twice, and a surface that is touched from outside is crossed twice or not at all. A triangle without area at the ray's
   time is never hit. >>exactness has the definition and the argument.

   Determinism. What a ray hits (mesh, triangle, t, u, v, normal) depends on ray and scene alone. It is bit for bit the
   same from single calls, many-ray calls of any order and grouping, all paths, all instruction sets, compilers and
   numbers of threads; a picture likewise, whatever its tile and packet sizes. Equal t go to the lower mesh, then the
   lower triangle. This rests on
     - one canonical triangle test that decides every hit; all else only refuses or takes what is certain to be refused
       or taken by it, with error bounds that are derived, not tuned;
     - the minimum over pairs (t, index), which is independent of order, and sums of fixed order (lights as they were
       added);
     - IEEE 754: only + - * / and square roots decide, never a function of libm whose last bits differ between systems;
     - operations that are neither fused nor reordered. The header forbids its own code to be contracted into
       multiply-adds, and clang to take liberties with it. (Fused operations are used on purpose where they only cull.)
   Two things are asked of you. No flags that change values: the implementation does not compile under those that gcc
   tells (-ffast-math, -fassociative-math and others); any other that has an effect, as clang's -ffp-contract=fast, is
   found by a test of the arithmetic when a scene is created. pktrt_scene_create then fails, and pktrt_last_error(NULL)
   names the flag to drop. And threads that round to nearest and do not flush denormal numbers to zero: the one that
   creates a scene is tested, the others are yours. (A program linked with -ffast-math flushes in all of them.)
   Statistics may differ slightly by instruction set: what is culled is not promised, only what is hit.

   Threads. Many readers or one writer. Queries, pktrt_render_tile and pktrt_render_pass are readers of a committed
   scene. Everything that takes a scene that is not const is a writer, but for pktrt_render, which may run beside
   readers, though not beside itself on one scene. parallel_for may use any threads in any order; if it uses several, the
   other hooks must bear to be called from any of them, and progress from several at once. Scenes know nothing of each
   other.

   Memory. Every byte comes from allocate and goes to release, with its size, aligned to 64 bytes. Queries allocate
   nothing. A call that runs out of memory says so and leaves the last committed state.
     - Tree: 50 to 60 bytes per triangle for ordinary meshes (a smooth height field; the pool hall), nearly 50 more for
       each further key, and 4 to 5 for the list that refit needs. Loose triangles that overlap in heaps fill their
       blocks badly: expect 250 to 300 bytes.
     - While building: 88 bytes per triangle besides (of the high quality 38 more, at worst 136), and the old tree until
       the new one is done. Only a changed tree counts. A tree of the high quality holds up to a sixth more.
     - Meshes are retained: 12 bytes per vertex and key, as much again with normals, 12 per triangle with indices. The
       first pktrt_set_positions of a mesh makes room for a second set, which stays; pktrt_set_normals likewise.
     - Instances: about 430 bytes each and 72 for each mesh of its model, 84 more from its first pktrt_set_transform on;
       another key 150. The model once.
     - Rendering: about 280 KiB for each tile at work, 80 more where one light is asked for all, and up to 100 KiB for each
       generation of rays; 230 bytes for each triangle of a mesh that is a light (DRT), 180 for each light that is chosen
       from or visible, 2 MiB for a callback environment that is one, twice that while it is looked at; 28 bytes for each
       mesh if one is of glass; if it counts, 8 KiB for each tile of the picture; with several passes, 42 bytes for each
       pixel, 64 more with optional buffers.
     - Stack: at most 64 KiB in a query, about 64 KiB in a render, 17 KiB in a build, if compiled with optimisation, be
       it -O1. Without: up to 128 KiB in a query with gcc, 260 KiB with clang. Mind this when your threads have small
       stacks.
   pktrt_get_scene_info tells tree and mesh bytes.

   Limits. Coordinates up to 2^100 (PKTRT_MAX_COORD); 1024 keys (PKTRT_MAX_KEYS); 2^31 - 1 triangles
   (PKTRT_MAX_TRIANGLES); pictures of 65536 x 65536, 65536 samples, 50 generations of rays (PKTRT_MAX_DEPTH).
   The tree is at most 38 levels deep, whatever the triangles are: stacks have fixed sizes and cannot overflow.

   NaN and infinity. In meshes, lights, materials and cameras they are refused by name. In rays they never do harm: a
   ray with a NaN or infinity in origin or direction, a zero direction, an origin beyond 2^100, or an empty or NaN
   interval is a miss. tmax may be infinite, tmin negative.

   Leaving a surface. pktrt_spawn moves the origin off the plane of the triangle by the rounding of the origin and no
   more: 2^-24 (|n_x x| + |n_y y| + |n_z z|), n the unit normal (>>spawn has the rest). The ray cannot meet the triangle
   that it left, and what lies farther from it than that is seen, however large the scene is. (Where a ray is to end on
   a surface, move its end off by 2^-22 of its length: so far is it off when its direction is rounded.)

   Errors. Calls that can fail return a pktrt_status; pktrt_last_error names mesh, triangle and value. Refused input
   changes nothing, and nothing asserts, prints or exits. Queries cannot fail; they need scene and, if n > 0, arrays.


   INSTRUCTION SETS AND COMPILERS

   gcc and clang on x86: SSE2, AVX2 (with FMA, BMI, BMI2) and AVX-512 (F, DQ, BW, VL) are all compiled, each function
   for its own set, so there is no need for -mavx2 or -march=native. When a scene is created, CPU and operating
   system are asked, and the widest wins; pktrt_scene_desc.isa asks for a certain one. AVX-512 uses vectors of 16
   rays in frustum packets, all other kernels are 8 wide everywhere (SSE2, NEON, WebAssembly: two registers). On
   32-bit x86 compile with -msse2 -mfpmath=sse, on s390x where gcc is given a -std=c... with -fexcess-precision=fast
   as well.
   64-bit ARM: NEON. WebAssembly: its vectors, if compiled with -msimd128. gcc for MinGW: SSE2 at most, since it may
   misalign wide variables on the stack (GCC bug 54412). tcc and all else: scalar, the same code with loops over
   eight floats: good for stepping through in a debugger.
   Flags that change values are refused, see GUARANTEES; so is x87 arithmetic.
   A kernel has one name in this file, and one for each instruction set in a program: in a debugger (-g -O0)
   `break pktrt__single_closest_hit_avx2` stops in it; the scalar ones show arrays where others have vectors. An editor
   sees the kernels with PKTRT_IMPLEMENTATION, PKTRT_NO_SIMD and PKTRT__EDITOR defined, as .clangd does.


   THE PAPER, SECTION BY SECTION (it numbers no equations; `make map` checks that what is named here is there)

     1, figure 1               >>render, pktrt_mode; `make demo` has each scene in all three.
     2, shadow rays            >>direct, pktrt__light_add_direct(), chooses lights and makes packets; >>shade,
                               pktrt__light_shadow_rays8(), makes the rays: from surface to light, where the paper
                               mentions light to surface. Packets need no common origin here, and the ray leaves the
                               surface it must not hit.
     3.1, figure 2: packets    >>paper, 1 to 256 rays; pktrt__paper_find_first() has steps 1 to 4. SIMD is 8 rays wide,
                               not 4: step 1 tests the whole group of the first active ray.
     3.1, amortisation         >>paper: first active ray (1), interval arithmetic (2, pktrt__paper_interval_misses()),
                               the other rays (4). Planes around the rays (3, pktrt__paper_frustum_misses(), where
                               origin and main axis are common) are not the paper's: it speaks of a frustum only with
                               the grid (3.3). Planes around general packets, as >>frustum has them, are from the report
                               to which it refers for intervals, UUCS-06-010. A child is tested when its turn comes
                               rather than when its parent is opened: hits found meanwhile have shortened the rays.
                               Nothing starts below the root, as MLRT does. >>frustum and >>stream are this library's
                               own answer to the same question. They test every ray against every box that the planes
                               keep: the paper's packets test fewer boxes of camera rays and more of others. (Ours also
                               know where the active range ends, pktrt__paper_trim(), after Overbeck et al., and test
                               leaves' boxes by groups, pktrt__paper_leaf(): the paper's tested more triangles.)
     3.2, figure 3             >>assembly, pktrt__packet_assemble(); pktrt_assembly has all of them, and
                               tests/assembly.c figure 3 with the packets of 3.2.1. Shadow rays make one packet for each
                               light by default, and one for all lights as in the paper if asked for
                               (PKTRT_SHADOWS_TOGETHER). On the fast path, ray types take the surfaces of several
                               packets at once, which keeps packets full as rays thin out, and reflected and refracted
                               rays share a wave where they fit.
     3.2, NO PACKETS           PKTRT_ASSEMBLY_NONE: of secondary rays, as in the paper. Primary rays keep their packets,
                               as under "Single Ray" in table 1; PKTRT_PATH_SINGLE traces these alone, too.
     3.2, BLIND                >>generations, pktrt__packet_push_blindly(); halved above 128 rays.
     3.2.2, octants            PKTRT_ASSEMBLY_OCTANTS: of each type, that is, up to 8 groups each of reflected rays, of
                               refracted rays, and of shadow rays to each light. In the paper there are at most 16, 8 of
                               shadow rays and 8 of all others.
     3.3: a BVH                >>build. Eight children, not two: one load and one vector test serve all of them, for one
                               ray or a frustum, and all paths share one tree. Built by binned SAH with exact sweeps
                               near the leaves. Box tests per ray are therefore not comparable with the paper's one by
                               one.
     3.3, deformation          >>refit: fixed connectivity, bounds refitted; SAH cost against the cost at build tells
                               when to rebuild.
     4, figure 4: DRT          >>lens, >>direct, >>scattering. Shadow rays go to a point of each light, reflected rays
                               into a Phong lobe; at glass one ray goes on, or both if asked for (pktrt_branching).
                               examples/effects.c shows the effects one by one.
     4, triangle test          >>exactness, >>triangles: barycentric in place like Kensler and Shirley's, for the reason
                               the paper gives (nothing precomputed, so triangles can move), but in the sheared frame of
                               Woop et al., with edge signs that are exact, so that edges do not leak and all kernels
                               agree.
     4, motion blur            Times belong to rays, as in the paper. Boxes are interpolated to the ray's time, for
                               packets to the interval of their times (>>paper, pktrt__paper_box()); in the paper boxes
                               grow with the shutter (5.3.1).
     4, sampling               >>sampler: interleaved sampling among them, and its modern answer, samples whose error is
                               blue noise. All are static: the same for each frame. >>mappings: the lobe's mapping with
                               the paper's care, pktrt_map_phong(), and the naive one, pktrt_map_phong_naive(). What
                               they cost: section4 of bench/paper/paper.c.
     5.1, figure 5: scenes     examples/scenes.h: pool hall, conference and rtrt, made by code, about as many triangles
                               each.
     5.1, tests per ray        >>stats: tests are counted in lanes, one ray against one box or triangle; a test of a
                               whole packet counts as a cull, by its kind.
     5.1, shading              >>fresnel: exact terms. Depth to 50 (PKTRT_MAX_DEPTH); `attenuation` of pktrt_render_desc
                               cuts off rays by their weight.
     5.2, table 1, figure 6    table1 and figure6 of bench/paper/paper.c (`make bench`, bench/README.md), which measures
                               all results again, and what other sections claim; section31: what SIMD and amortisation
                               give. PKTRT_PAPER_STEPS_2007 leaves out what the paper's packets did not do: triangle
                               tests then grow with packets as in figure 6.
     5.3, table 2, table 3     table2, rays per second of the three modes; table3, of DRT, a pixel to a packet;
                               section5: time of more samples.
     5.3.1, figure 7           figure7: lens, lights, gloss and shutter; boxes that move beside such as grow with the
                               shutter.
     5.4, figure 8             figure8. To compare with the figure read vector_box_tests and vector_triangle_tests of
                               by_depth in pktrt_stats, tests of eight lanes of which some may be idle: ray types need
                               fewer of both, as in the paper. Read from box_tests it comes out reversed, since packets
                               of few rays, as runs leave them, test few rays in mostly idle lanes.
     6, shading in bulk        >>shade: by eights. Materials' hooks see many points at once. section6: its share.

   The paper path keeps count even if you do not ask for it: it is for reading and comparing tests, not for racing.


   REFERENCES

     Boulos, Edwards, Lacewell, Kniss, Kautz, Shirley, Wald: Packet-based Whitted and Distribution Ray Tracing. Graphics
       Interface 2007.
     Boulos, Wald, Shirley: Geometric and Arithmetic Culling Methods for Entire Ray Packets. University of Utah,
       technical report UUCS-06-010, 2006. (Intervals, and planes around any packet.)
     Wald, Boulos, Shirley: Ray Tracing Deformable Scenes using Dynamic Bounding Volume Hierarchies. ACM Transactions on
       Graphics 26(1), 2007. (First active ray, refit.)
     Overbeck, Ramamoorthi, Mark: Large Ray Packets for Real-time Whitted Ray Tracing. IEEE Interactive Ray Tracing
       2008. (Ranges that also know their last active ray.)
     Wald: On fast Construction of SAH-based Bounding Volume Hierarchies. IEEE Interactive Ray Tracing 2007.
     Dammertz, Hanika, Keller: Shallow Bounding Volume Hierarchies for Fast SIMD Ray Tracing of Incoherent Rays.
       Computer Graphics Forum 27(4), 2008.
     Ernst, Greiner: Multi Bounding Volume Hierarchies. IEEE Interactive Ray Tracing 2008.
     Barringer, Akenine-Moeller: Dynamic Ray Stream Traversal. ACM TOG 33(4), 2014. (A relative of >>stream.)
     Kensler, Shirley: Optimizing Ray-Triangle Intersection via Automated Search. IEEE Interactive Ray Tracing 2006.
     Whitted: An Improved Illumination Model for Shaded Display. Communications of the ACM 23(6), 1980.
     Cook, Porter, Carpenter: Distributed Ray Tracing. SIGGRAPH 1984.
     Keller, Heidrich: Interleaved Sampling. Eurographics Workshop on Rendering 2001.
     Ahmed, Wonka: Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels.
       ACM TOG 39(6), 2020.
     Laine, Karras: Stratified Sampling for Stochastic Transparency. Eurographics Symposium on Rendering 2011.
     Burley: Practical Hash-based Owen Scrambling. Journal of Computer Graphics Techniques 9(4), 2020.
     Kensler: Correlated Multi-Jittered Sampling. Pixar technical memo 13-01, 2013.
     Shirley, Chiu: A Low Distortion Map Between Disk and Square. Journal of Graphics Tools 2(3), 1997.
     Duff et al.: Building an Orthonormal Basis, Revisited. Journal of Computer Graphics Techniques 6(1), 2017.
     Woop, Benthin, Wald: Watertight Ray/Triangle Intersection. Journal of Computer Graphics Techniques 2(1), 2013.
*/
/* ---------------------------------------------------------------------------------------------------------------------
   DECLARATIONS
   ------------------------------------------------------------------------------------------------------------------ */
#ifndef PKTRT_H
#define PKTRT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef PKTRT_NO_RENDER
#define PKTRT__DECLARED_NO_RENDER
#endif
#ifdef PKTRT_NO_NORMALS
#define PKTRT__DECLARED_NO_NORMALS
#endif
#ifdef PKTRT_NO_REMOVAL
#define PKTRT__DECLARED_NO_REMOVAL
#endif
#ifdef PKTRT_NO_INSTANCES
#define PKTRT__DECLARED_NO_INSTANCES
#endif
#ifdef PKTRT_NO_SURFACES
#define PKTRT__DECLARED_NO_SURFACES
#endif

#ifdef PKTRT_STATIC
#define PKTRT__DECLARED_STATIC
#endif

#if defined(PKTRT_STATIC) && defined(PKTRT_DEF)
#error "PKTRT_STATIC makes functions static, PKTRT_DEF says what else stands before them: define only one of them"
#elif defined(PKTRT_STATIC) && (defined(__GNUC__) || defined(__clang__))
#define PKTRT_DEF static __attribute__((__unused__)) /* a file need not call everything it has a copy of */
#elif defined(PKTRT_STATIC)
#define PKTRT_DEF static
#elif !defined(PKTRT_DEF)
#define PKTRT_DEF extern
#endif

#ifdef __cplusplus
extern "C" {
#endif

#define PKTRT_VERSION 1506              /* major * 10000 + minor * 100 + patch */
#define PKTRT_NONE 0xFFFFFFFFu          /* "no mesh", "no triangle" */
#define PKTRT_MAX_TRIANGLES 2147483647u /* of a scene; more: PKTRT_LIMIT */
#define PKTRT_MAX_KEYS 1024u            /* motion keys of one mesh; more: PKTRT_LIMIT */
#define PKTRT_MAX_DEPTH 50              /* generations of secondary rays in a render */
#define PKTRT_MAX_COORD 1.2676506e30f   /* 2^100; a vertex beyond it: PKTRT_LIMIT, a ray origin beyond it: a miss */

/* The PKTRT_VERSION that the implementation was compiled with. */
PKTRT_DEF uint32_t pktrt_version(void);

/* >>types ---------------------------------------------------------------------------------------------------------- */

typedef struct pktrt_scene pktrt_scene; /* opaque: meshes, materials, lights and the tree over them */

typedef enum pktrt_isa {
  PKTRT_ISA_AUTO = 0, /* the widest this machine and this build have */
  PKTRT_ISA_SCALAR,
  PKTRT_ISA_SSE2,
  PKTRT_ISA_AVX2,
  PKTRT_ISA_AVX512,
  PKTRT_ISA_NEON,
  PKTRT_ISA_WASM, /* WebAssembly's 128 bits, if compiled with -msimd128 */
  PKTRT_ISA_COUNT
} pktrt_isa;

typedef enum pktrt_build_quality {
  PKTRT_BUILD_DEFAULT = 0,
  PKTRT_BUILD_FAST, /* coarser bins: for scenes rebuilt every frame */
  PKTRT_BUILD_HIGH  /* finer bins, large triangles in several leaves, then subtrees move to better places: three times
                       the time, a part of it not in parallel. For what stays: refits give leaves whole triangles */
} pktrt_build_quality;

/* What refit does when deformation has made the tree bad (its SAH cost exceeds 1.5 times the cost at build). */
typedef enum pktrt_rebuild {
  PKTRT_REBUILD_ADVISE = 0, /* says so in pktrt_scene_info and through the log hook */
  PKTRT_REBUILD_NEVER,      /* says nothing */
  PKTRT_REBUILD_AUTOMATIC   /* rebuilds the trees concerned */
} pktrt_rebuild;

/* Which traversal answers many-ray queries and renders. All give the same bits. */
typedef enum pktrt_path {
  PKTRT_PATH_FAST = 0, /* frustum packets where rays agree, mask streams where they do not */
  PKTRT_PATH_PAPER,    /* packets as in Boulos et al. 2007, sections 3.1-3.3: plain, for reading and comparing */
  PKTRT_PATH_SINGLE    /* each ray alone */
} pktrt_path;

/* A label for statistics; it changes nothing else. */
typedef enum pktrt_ray_type {
  PKTRT_RAY_PRIMARY = 0,
  PKTRT_RAY_SHADOW,
  PKTRT_RAY_REFLECTION,
  PKTRT_RAY_REFRACTION,
  PKTRT_RAY_OTHER,
  PKTRT_RAY_TYPE_COUNT
} pktrt_ray_type;

/* >>errors --------------------------------------------------------------------------------------------------------- */

typedef enum pktrt_status {
  PKTRT_OK = 0,
  PKTRT_INVALID_ARGUMENT,
  PKTRT_OUT_OF_MEMORY,
  PKTRT_LIMIT,
  PKTRT_NOT_COMMITTED,
  PKTRT_CANCELLED
} pktrt_status;

/* One readable sentence for a status; never NULL, also for values that are no status. */
PKTRT_DEF const char *pktrt_status_string(pktrt_status);

/* The detail of the last failed call on this scene: which mesh, which triangle, what value. Valid until the next
   call that changes the scene; queries never write it. NULL asks about a failed create. Never returns NULL. */
PKTRT_DEF const char *pktrt_last_error(const pktrt_scene *);

/* >>hooks ---------------------------------------------------------------------------------------------------------- */

typedef struct pktrt_scene_desc { /* zeroed: sensible defaults */
  /* NULL: malloc, on Linux with large pages for what is large. Must be thread-safe if parallel_for is. */
  void *(*allocate)(void *user, size_t size, size_t align);
  void (*release)(void *user, void *ptr, size_t size); /* set both or neither */
  /* Runs body(arg, i) for i in [0,n), in any order, on any threads, and returns when all are done. NULL: serial. */
  void (*parallel_for)(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg);
  void *user;    /* handed to every hook */
  pktrt_isa isa; /* AUTO, or that one, or create fails */
  pktrt_build_quality quality;
  pktrt_rebuild rebuild;
  /* One finished sentence at a time, without newline; level 0 is a warning, 1 is information. NULL: silence. */
  void (*log)(void *user, int level, const char *sentence);
} pktrt_scene_desc;

PKTRT_DEF pktrt_scene *pktrt_scene_create(const pktrt_scene_desc *desc); /* NULL desc = all defaults; NULL on failure */
PKTRT_DEF void pktrt_scene_destroy(pktrt_scene *);                       /* NULL is fine */

/* >>mesh ----------------------------------------------------------------------------------------------------------- */

typedef struct pktrt_mesh_desc {
  const float *positions; /* key_count blocks of vertex_count vertices; copied */
  uint32_t vertex_count;
  uint32_t position_stride; /* bytes from vertex to vertex; 0 = 12. No alignment beyond a float's is asked for. */
  const uint32_t *indices;  /* triangle_count * 3; NULL: 0,1,2, 3,4,5, ... (a triangle soup) */
  uint32_t triangle_count;
  uint32_t key_count;     /* motion keys spread evenly over time [0,1]; 0 and 1 both mean static */
  const float *normals;   /* optional shading normals of equal lengths, tight, key_count blocks */
  uint32_t material;      /* 0 = the default one; else an index from pktrt_add_material, looked at when rendering */
  uint32_t group;         /* any number: what changes in a group is built anew without the others. 0: the rest */
  uint32_t mask;          /* queries whose masks share no bit with it do not see the mesh; 0: all bits */
  const float *texcoords; /* optional: vertex_count pairs, tight, for all keys; any finite values */
} pktrt_mesh_desc;

/* *mesh (may be NULL) receives the index that hits report. Bad input (index out of range, NaN, infinity, counts that
   overflow, NULL where data is needed) is refused with a status and a detail, and the scene stays as it was. Degenerate
   triangles are accepted and never hit. */
PKTRT_DEF pktrt_status pktrt_add_mesh(pktrt_scene *, const pktrt_mesh_desc *, uint32_t *mesh);

/* Builds what changed: the trees of those meshes (same group, number of keys and mask) of which one is new, removed or
   has new positions. An empty scene is fine. On failure the last committed state stays. */
PKTRT_DEF pktrt_status pktrt_commit(pktrt_scene *);

/* Deformation with fixed connectivity: replace one key's positions (and normals), then refit. Stride as at add_mesh. */
PKTRT_DEF pktrt_status pktrt_set_positions(pktrt_scene *, uint32_t mesh, uint32_t key, const float *positions);
#ifndef PKTRT_NO_NORMALS
PKTRT_DEF pktrt_status pktrt_set_normals(pktrt_scene *, uint32_t mesh, uint32_t key, const float *normals);
#endif

/* Fits the boxes above changed meshes and instances, exactly as if computed anew. Where a mesh or an instance was added
   or removed since the last commit: PKTRT_NOT_COMMITTED. */
PKTRT_DEF pktrt_status pktrt_refit(pktrt_scene *);

#ifndef PKTRT_NO_REMOVAL
/* Removes a mesh: the next commit, until which queries still see it, gives its memory back. Other indices stay as they
   are. Its own has no triangles then, and is given to a mesh that is added later, if that has no more triangles. */
PKTRT_DEF pktrt_status pktrt_remove_mesh(pktrt_scene *, uint32_t mesh);
/* Hides a mesh from rays, or shows it again, from the next commit or refit on; either costs what fitting its tree does.
   A mesh of an instance stands for all of the instance, at no cost but that of fitting the tree above instances. */
PKTRT_DEF pktrt_status pktrt_set_enabled(pktrt_scene *, uint32_t mesh, bool enabled);
#endif

#ifndef PKTRT_NO_INSTANCES
/* >>instance ------------------------------------------------------------------------------------------------------- */

/* A model is a set of meshes that is built once, when it is added, and shown by instances alone. Meshes are as in
   pktrt_add_mesh, motion keys and materials of the scene included; groups mean nothing there. *model may be NULL. */
PKTRT_DEF pktrt_status pktrt_add_model(pktrt_scene *, const pktrt_mesh_desc *meshes, uint32_t mesh_count,
                                       uint32_t *model);

typedef struct pktrt_instance_desc {
  uint32_t model;
  uint32_t key_count;      /* motion keys spread evenly over time [0,1]; 0 and 1 both mean at rest */
  const float *transforms; /* key_count matrices of 3 x 4 by rows: place = matrix (x, y, z, 1); NULL: the identity */
  uint32_t mask;           /* as of meshes, for all of them; those of the model's meshes count too */
} pktrt_instance_desc;

/* Places a model: turned, scaled unevenly, sheared or mirrored as you like. Elements move along straight lines from key
   to key. An instance takes a mesh index for each mesh of its model, from the next one on: hits, materials, ties and
   pktrt_spawn go by these. It is seen from the next commit on, as meshes are. A transform that flattens space at any
   time, or may, is refused. *instance may be NULL. */
PKTRT_DEF pktrt_status pktrt_add_instance(pktrt_scene *, const pktrt_instance_desc *, uint32_t *instance);
/* Replaces one key's 12 elements, for the next commit or refit; either costs by the number of instances alone. */
PKTRT_DEF pktrt_status pktrt_set_transform(pktrt_scene *, uint32_t instance, uint32_t key, const float *transform);
#ifndef PKTRT_NO_REMOVAL
/* Removes an instance with its meshes, as pktrt_remove_mesh does. Its indices wait for another instance of its model. */
PKTRT_DEF pktrt_status pktrt_remove_instance(pktrt_scene *, uint32_t instance);
#endif
/* Tells which instance a mesh index belongs to, and which mesh of its model it stands for (either may be NULL); false
   for a mesh that was added directly, or does not exist. */
PKTRT_DEF bool pktrt_get_mesh_source(const pktrt_scene *, uint32_t mesh, uint32_t *instance, uint32_t *model_mesh);
#endif

/* What the committed scene is made of. */
typedef struct pktrt_scene_info {
  pktrt_isa isa;                    /* the instruction set in use, never AUTO */
  uint32_t mesh_count;              /* committed mesh indices, those that wait for a mesh included */
  uint32_t moving_meshes;           /* of these, meshes with two or more keys */
  uint64_t triangles;               /* committed, degenerate ones included */
  uint64_t degenerate;              /* of these, triangles without area at any time, or hidden */
  uint64_t nodes;                   /* 8-wide nodes */
  uint64_t leaf_blocks;             /* blocks of up to 8 triangles */
  uint64_t tree_bytes;              /* nodes and leaf blocks */
  uint64_t mesh_bytes;              /* retained positions, indices, normals */
  float bounds_lo[3], bounds_hi[3]; /* over all keys; lo > hi if there is no triangle */
  double sah_at_build;              /* expected node visits of a random line through the bounds; over trees, by area */
  double sah_now;                   /* the same after refits; sah_now > 1.5 * sah_at_build asks for a rebuild */
  bool rebuild_advised;
  uint32_t
      instance_count; /* committed instances; triangles, nodes and bytes count each model once, with what places it */
} pktrt_scene_info;
PKTRT_DEF void pktrt_get_scene_info(const pktrt_scene *, pktrt_scene_info *);

/* Marks all as changed: the next commit builds all trees anew (where a rebuild is advised). Refits leave the mark. */
PKTRT_DEF pktrt_status pktrt_mark_changed(pktrt_scene *);

/* "scalar", "sse2", "avx2", "avx512", "neon", "wasm", "auto"; never NULL */
PKTRT_DEF const char *pktrt_isa_string(pktrt_isa);
/* Whether this build and this machine (CPU and operating system) can run it. */
PKTRT_DEF bool pktrt_isa_available(pktrt_isa);

/* >>query ---------------------------------------------------------------------------------------------------------- */

typedef struct pktrt_ray {
  float origin[3];
  float tmin; /* direction need not be normalised; t is in units of its length */
  float direction[3];
  float tmax; /* hits are reported for tmin < t < tmax; tmax may be INFINITY */
  float time; /* clamped to [0,1] (NaN: 0); looked at only if the scene moves */
} pktrt_ray;  /* a zeroed ray has tmax 0 and hits nothing */

/* The ray from an origin in a direction, with tmin 0, tmax INFINITY and time 0. */
PKTRT_DEF pktrt_ray pktrt_make_ray(const float origin[3], const float direction[3]);

typedef struct pktrt_hit {
  float t;           /* on a miss: the ray's tmax */
  float u, v;        /* barycentrics: point = (1-u-v) p0 + u p1 + v p2; 0 on a miss */
  float normal[3];   /* along cross(p1-p0, p2-p0) at the ray's time, largest component 1 or -1; 0 on a miss */
  uint32_t mesh;     /* PKTRT_NONE on a miss */
  uint32_t triangle; /* index within the mesh; PKTRT_NONE on a miss */
} pktrt_hit;

/* Queries: thread-safe on a committed scene, allocate nothing, use at most 64 KiB of stack, and never fail. A ray
   with a non-finite origin or direction, a zero direction, or an empty or NaN interval is a miss. */
PKTRT_DEF bool pktrt_intersect(const pktrt_scene *, const pktrt_ray *, pktrt_hit *);
PKTRT_DEF bool pktrt_occluded(const pktrt_scene *, const pktrt_ray *);

/* The least (t, mesh, triangle) that is greater than previous's and inside the ray's interval; previous NULL: the first.
   Where previous is a miss, so is this. A chain of calls, each with the last one's hit, visits every crossing once, those
   at equal t too: for alpha, decals, thickness, CSG. previous and hit may be the same. For _n: an array, or NULL. */
PKTRT_DEF bool pktrt_intersect_after(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *previous, pktrt_hit *);
PKTRT_DEF void pktrt_intersect_after_n(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, pktrt_hit *,
                                       size_t n);
/* The number of crossings inside the ray's interval; the nearest `capacity` of them in that order, or all if they are
   less. Of several rays: capacity hits for each, and a count each. */
PKTRT_DEF size_t pktrt_intersect_all(const pktrt_scene *, const pktrt_ray *, pktrt_hit *hits, size_t capacity);
PKTRT_DEF void pktrt_intersect_all_n(const pktrt_scene *, const pktrt_ray *, pktrt_hit *hits, size_t capacity,
                                     size_t *counts, size_t n);

/* How often a closed mesh winds around a point (three floats) at a time: 0 outside, 1 inside where triangles appear
   counter-clockwise from outside, -1 where clockwise, more where it overlaps itself. Exact, whatever the triangles are;
   for a point on the surface unspecified, but the same everywhere. An open mesh gets the exits minus the entries of a ray
   along x. 0 for a mesh that is not there. Of several points: times NULL is 0 for all. */
PKTRT_DEF int pktrt_winding(const pktrt_scene *, uint32_t mesh, const float point[3], float time);
PKTRT_DEF void pktrt_winding_n(const pktrt_scene *, uint32_t mesh, const float *points, const float *times, int *out,
                               size_t n);

/* n rays in any order, best like their neighbours: packets form by themselves. No overlaps; n = 0 with NULL is fine. */
PKTRT_DEF void pktrt_intersect_n(const pktrt_scene *, const pktrt_ray *, pktrt_hit *, size_t n);
PKTRT_DEF void pktrt_occluded_n(const pktrt_scene *, const pktrt_ray *, bool *, size_t n);
/* (In C++ a std::vector<bool> is no array of bool: use std::unique_ptr<bool[]>, or vectors of char and a cast.) */

/* The structure-of-arrays twin: each pointer an array of n values, no alignment asked. */
typedef struct pktrt_rays {
  const float *origin[3];
  const float *direction[3];
  const float *tmin; /* NULL: 0 for all */
  const float *tmax; /* NULL: INFINITY for all */
  const float *time; /* NULL: 0 for all */
} pktrt_rays;
typedef struct pktrt_hits { /* NULL: not wanted, not stored */
  float *t, *u, *v;
  float *normal[3]; /* all three or none */
  uint32_t *mesh, *triangle;
} pktrt_hits;
PKTRT_DEF void pktrt_intersect_soa(const pktrt_scene *, const pktrt_rays *, const pktrt_hits *, size_t n);
PKTRT_DEF void pktrt_occluded_soa(const pktrt_scene *, const pktrt_rays *, bool *, size_t n);

/* The ray that leaves a hit in the given direction without meeting the triangle it left: see "Leaving a surface" above;
   same time, tmin 0, tmax INFINITY. Reads the hit, and the ray but tmin and tmax. On a miss *out hits nothing. */
PKTRT_DEF void pktrt_spawn(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, const float direction[3],
                           pktrt_ray *out);

PKTRT_DEF void pktrt_spawn_n(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, const float *directions,
                             pktrt_ray *out, size_t n); /* 3 floats for each direction */

#ifndef PKTRT_NO_SURFACES
/* What one shades with; zeros and PKTRT_NONE on a miss. */
typedef struct pktrt_surface_info {
  float position[3];       /* of the hit, as exactly as pktrt_spawn has it */
  float normal[3];         /* unit, of the triangle, on the side that the ray came from */
  float shading_normal[3]; /* unit, interpolated where the mesh has normals, else as `normal`; on the same side */
  float texcoord[2];       /* interpolated; 0 where the mesh has none */
  uint32_t material;       /* that of the mesh */
  uint32_t instance;       /* PKTRT_NONE: the mesh was added directly */
  bool inside;             /* the ray came from where corners appear clockwise */
} pktrt_surface_info;
PKTRT_DEF void pktrt_surface(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, pktrt_surface_info *);
PKTRT_DEF void pktrt_surface_n(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, pktrt_surface_info *,
                               size_t n);
/* As pktrt_spawn, from a point of a triangle: for lightmaps, where no ray was before. u and v outside the triangle are
   points of its plane. Where there is no such triangle, or it has no area at that time, *out hits nothing. */
PKTRT_DEF void pktrt_spawn_at(const pktrt_scene *, uint32_t mesh, uint32_t triangle, float u, float v, float time,
                              const float direction[3], pktrt_ray *out);
/* The same for mesh, triangle, u and v of n hits, of which nothing else is read; times NULL: 0 for all. */
PKTRT_DEF void pktrt_spawn_at_n(const pktrt_scene *, const pktrt_hit *, const float *times, const float *directions,
                                pktrt_ray *out, size_t n);
#endif

/* >>stats ---------------------------------------------------------------------------------------------------------- */

/* Counts of work; added to, never reset. A "lane" is one ray against one box or triangle. */
typedef struct pktrt_counts {
  uint64_t rays; /* valid rays traced */
  uint64_t hits;
  uint64_t packets;          /* packets (or streams, or single rays) formed of them */
  uint64_t node_visits;      /* nodes opened, by a packet or a ray */
  uint64_t box_tests;        /* lanes: ray against child box; empty places of nodes do not count */
  uint64_t triangle_tests;   /* lanes: ray against triangle */
  uint64_t first_hits;       /* paper path: child entered because the first active ray hit it */
  uint64_t interval_culls;   /* paper path: child dropped by interval arithmetic, all rays at once */
  uint64_t frustum_culls;    /* child dropped by the four planes, all rays at once */
  uint64_t ray_culls;        /* child dropped after every active ray missed it */
  uint64_t triangle_culls;   /* triangle dropped by the four planes, all rays at once */
  uint64_t canonical_tests;  /* lanes that single precision took for a hit within reach, or could not rule out */
  uint64_t settlings;        /* of these, lanes that the canonical test in double precision had to decide */
  uint64_t fallbacks;        /* packets that turned into streams on their way down */
  uint64_t vector_box_tests; /* paper path: tests of eight lanes at once, whether or not all of them are busy */
  uint64_t vector_triangle_tests;
  uint64_t later_hits; /* paper path: child entered because a ray behind the first active one hit it. On that path
                               the children of opened nodes are first_hits + later_hits + interval_culls +
                               frustum_culls + ray_culls and, for any hit, those told by PKTRT_EVENT_NONE_LEFT */
} pktrt_counts;
typedef struct pktrt_stats {
  pktrt_counts by_type[PKTRT_RAY_TYPE_COUNT];
  /* The rest counts renders only. */
  pktrt_counts by_depth[PKTRT_MAX_DEPTH + 2]; /* by bounces since the camera; shadow rays one more than their surface */
  uint64_t samples;                           /* primary rays asked for */
  uint64_t tree_depth;                        /* summed over samples: bounces of the deepest ray, shadow rays apart */
} pktrt_stats;

/* What a packet of the paper path does besides testing its rays, see >>paper. No answer depends on it, only counts of work
   and events do. Or them together; 0 means all. */
typedef enum pktrt_paper_step {
  PKTRT_PAPER_STEP_GROUP = 1,       /* tests the whole group of the first active ray; without: this ray alone */
  PKTRT_PAPER_STEP_INTERVALS = 2,   /* asks interval arithmetic, if the first active ray misses */
  PKTRT_PAPER_STEP_FRUSTUM = 4,     /* asks four planes, where origin and main axis are common */
  PKTRT_PAPER_STEP_TRIM = 8,        /* looks for the end of the active range, where its beginning has moved */
  PKTRT_PAPER_STEP_LEAF_BOXES = 16, /* tests groups against the box of a leaf before its triangles */
  PKTRT_PAPER_STEP_ORDER = 32,      /* visits children from near to far; without: those in places 7, 6, ... 0 */
  PKTRT_PAPER_STEP_NONE = 64,       /* alone: takes none of them */
  /* Those of Boulos et al. 2007. Eight children share a node here, where theirs had two: compare triangle tests with
     theirs, and not box tests. */
  PKTRT_PAPER_STEPS_2007 = PKTRT_PAPER_STEP_GROUP | PKTRT_PAPER_STEP_INTERVALS | PKTRT_PAPER_STEP_ORDER
} pktrt_paper_step;

/* Paper path only, for teaching: one call per decision about a packet. A node that is opened has up to eight children.
   Each of them gets one verdict when its turn comes, FIRST_HIT to ALL_MISS or, for any hit, NONE_LEFT; of empty places
   nothing is told. A packet goes through the trees of the scene one by one, and where keys are several, once for each
   interval of time that its rays lie in: each time from node 0 on. */
typedef enum pktrt_event_kind {
  PKTRT_EVENT_NODE = 0,      /* the packet opens node `index`; first active ray in `ray` */
  PKTRT_EVENT_FIRST_HIT,     /* child `child` of node `index` is entered: the first active ray hit it */
  PKTRT_EVENT_INTERVAL_CULL, /* child dropped: interval arithmetic says that every ray misses */
  PKTRT_EVENT_FRUSTUM_CULL,  /* child dropped: it lies outside one of the four planes */
  PKTRT_EVENT_LATER_HIT,     /* child entered: a later ray, now the first active one, hit it */
  PKTRT_EVENT_ALL_MISS,      /* child dropped: every active ray was tested and missed */
  PKTRT_EVENT_LEAF,      /* the packet enters block `index`: rays of its range that hit the box meet the triangles */
  PKTRT_EVENT_HIT,       /* ray `ray` found a nearer hit (any hit: its hit), in lane `child` of block `index`; each
                               is told once, and the last one of a ray is its answer */
  PKTRT_EVENT_NONE_LEFT, /* any hit: child dropped, since no ray of its range, which began at `ray`, is left */
  PKTRT_EVENT_TRIM,      /* before a LATER_HIT: the active range of the child ends earlier, see `active` */
  PKTRT_EVENT_LEAF_TEST  /* in block `index`, of a group of rays from `ray` on: `active` of them meet the triangles */
} pktrt_event_kind;
typedef struct pktrt_event {
  pktrt_event_kind kind;
  uint32_t index, child, ray; /* `ray`: index within the packet, in an instance among those that enter it together */
  uint32_t active;            /* rays from `ray` to the end of the active range; not all of them need be tested */
  uint32_t tested; /* rays tested against a box since the event before: for all events, they add up to box_tests */
  uint32_t tree;   /* whose indices these are, see pktrt_get_tree */
  uint32_t packet; /* number of the packet in the call, from 0; in an instance PKTRT_NONE; of a render 0 */
  uint32_t depth;  /* of the node at hand, or of the child at hand: how many are above it */
} pktrt_event;

/* Queries with everything spelled out. A zeroed desc is pktrt_intersect_n. */
typedef struct pktrt_query_desc {
  pktrt_path path;
  uint32_t mask;                                  /* see pktrt_mesh_desc; 0: all bits */
  uint32_t packet_size;                           /* rays in a packet of the paper path, 1 to 256; 0: 64 */
  pktrt_ray_type type;                            /* which row of *stats to add to */
  pktrt_stats *stats;                             /* NULL: count nothing, at no cost (the paper path always counts) */
  void (*trace)(void *user, const pktrt_event *); /* paper path; NULL: none */
  void *user;
  uint32_t paper_steps; /* bits of pktrt_paper_step; 0: all */
} pktrt_query_desc;
/* As the _n and _soa calls. Values out of range are taken as their defaults: queries never fail. */
PKTRT_DEF void pktrt_intersect_ex(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, pktrt_hit *,
                                  size_t n);
PKTRT_DEF void pktrt_occluded_ex(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, bool *, size_t n);
PKTRT_DEF void pktrt_intersect_soa_ex(const pktrt_scene *, const pktrt_query_desc *, const pktrt_rays *,
                                      const pktrt_hits *, size_t n);
PKTRT_DEF void pktrt_occluded_soa_ex(const pktrt_scene *, const pktrt_query_desc *, const pktrt_rays *, bool *,
                                     size_t n);

/* >>tree ----------------------------------------------------------------------------------------------------------- */

/* The trees of a committed scene, to look at: one for the meshes of each group, mask and number of keys, then those of
   models. Builds with PKTRT_NO_STATS have nothing to show. */
typedef struct pktrt_tree {
  uint32_t group, mask, keys; /* of its meshes */
  uint32_t model;             /* in the order in which they were added; PKTRT_NONE: its meshes were added directly */
  uint32_t nodes, leaves;     /* how many; node 0 is the root */
  float lo[3], hi[3];         /* bounds of all it holds, at all times */
} pktrt_tree;
typedef struct pktrt_node { /* places for eight children; events call them `child`, and the lanes of a leaf as well */
  uint32_t child[8];        /* index of a node, or of a leaf; PKTRT_NONE: the place is empty */
  bool leaf[8];
  float lo[8][3], hi[8][3]; /* boxes of the children at the time that was asked for */
  /* Of a leaf: its triangles, as in pktrt_hit, of a model as they were given to it; PKTRT_NONE: none in this lane. */
  uint32_t mesh[8][8], triangle[8][8];
  uint8_t order[8][8]; /* for each octant of directions (bit a: component a is negative): places from near to far */
} pktrt_node;
/* Fill *out. false: there is no tree or node of this number, and *out is zeroed. */
PKTRT_DEF bool pktrt_get_tree(const pktrt_scene *, uint32_t tree, pktrt_tree *out);
PKTRT_DEF bool pktrt_get_node(const pktrt_scene *, uint32_t tree, uint32_t index, float time, pktrt_node *out);

/* >>report --------------------------------------------------------------------------------------------------------- */

/* What costs something where it is there. What a scene has and a picture asks for is found before the first ray; code
   and memory for the rest stay unused. PKTRT_NO_... switches leave features out of a build. */
typedef enum pktrt_feature {
  PKTRT_FEATURE_MOTION = 1,         /* meshes with two or more keys, cameras between two poses */
  PKTRT_FEATURE_STATS = 2,          /* counts of work, events */
  PKTRT_FEATURE_PAPER = 4,          /* the paper's path */
  PKTRT_FEATURE_RENDER = 8,         /* pictures, and all that follows */
  PKTRT_FEATURE_MIRROR = 16,        /* mirrors and varnish */
  PKTRT_FEATURE_DIELECTRIC = 32,    /* glass */
  PKTRT_FEATURE_CONDUCTOR = 64,     /* metal */
  PKTRT_FEATURE_GLOSS = 128,        /* Phong lobes */
  PKTRT_FEATURE_NORMALS = 256,      /* shading normals */
  PKTRT_FEATURE_TEXTURES = 512,     /* textures and shaders of materials */
  PKTRT_FEATURE_AREA_LIGHTS = 1024, /* lights that are quads, spheres, meshes or the environment */
  PKTRT_FEATURE_LENS = 2048,
  PKTRT_FEATURE_SHUTTER = 4096,
  PKTRT_FEATURE_INSTANCES = 8192,
  PKTRT_FEATURE_GROUPS = 16384,  /* groups and masks */
  PKTRT_FEATURE_REMOVAL = 32768, /* meshes that were removed or are hidden */
  PKTRT_FEATURE_SURFACES = 65536 /* texture coordinates and cutouts */
} pktrt_feature;
PKTRT_DEF const char *pktrt_feature_string(pktrt_feature); /* "motion", "stats", ...; of one bit; never NULL */

struct pktrt_render_desc;
typedef struct pktrt_scene_report {
  pktrt_scene_info info;  /* what it is made of */
  uint32_t built;         /* bits: features of this build */
  uint32_t found;         /* of these, what the committed scene has, and the description asks for */
  uint32_t used;          /* of these, what runs: the mode takes no notice of the others, or nothing asks for them */
  uint64_t bytes;         /* of all below but `worker` and `passes` */
  uint64_t nodes, blocks; /* bytes of the trees, at their first keys */
  uint64_t motion;        /* of trees and meshes: what further keys take */
  uint64_t positions, normals, indices; /* bytes of what was copied in; positions: with those that wait for a commit */
  uint64_t texcoords;                   /* likewise */
  uint64_t ids;                         /* which triangles a block holds, for refits */
  uint64_t materials;                   /* bytes of materials and lights */
  uint64_t worker;    /* bytes that a worker has while it renders a tile, for a generation of secondary rays */
  uint64_t passes;    /* bytes that a render keeps for its pixels, if it makes several passes */
  uint64_t instances; /* bytes of what places instances, but for the tree above them, which is among those of trees */
} pktrt_scene_report;
/* For a render with this description (whose pixels may be NULL), or if it is NULL, for queries. */
PKTRT_DEF void pktrt_get_scene_report(const pktrt_scene *, const struct pktrt_render_desc *, pktrt_scene_report *);
/* The same in lines of text, as snprintf does it: returns its length, which may exceed the room there is. */
PKTRT_DEF size_t pktrt_scene_report_text(const pktrt_scene_report *, char *text, size_t room);

#ifndef PKTRT_NO_RENDER
/* >>camera --------------------------------------------------------------------------------------------------------- */

typedef struct pktrt_camera { /* right-handed: looking along target - eye, x to the right, y up */
  float eye[3], target[3];
  float up[3];    /* zero: +y; need not be perpendicular, must not be parallel to the view */
  float fov_y;    /* full vertical angle in degrees, (0,180); 0: 45 */
  float time;     /* when the shutter opens, [0,1] */
  float shutter;  /* how long it stays open: rays have times in [time, time + shutter], which ends at 1 */
  float aperture; /* diameter of the lens; 0: a pinhole */
  float focus;    /* distance, along the view, of the plane that is sharp; 0: that of target */
  bool moving;    /* eye, target and up move: given above for time 0, below for time 1, on straight lines */
  float eye_end[3], target_end[3];
  float up_end[3]; /* zero: as up */
} pktrt_camera;

/* The renderer's own ray, bit for bit, through the place (x, y) of a picture, in pixels from its upper left corner: the
   middle of pixel (i, j) is (i + 0.5, j + 0.5). lens: a point of [0,1)^2 that pktrt_map_disk takes to the lens; NULL:
   its middle, as in RCS and WRT. time: when the ray starts, in [0,1]; a camera at rest ignores it. The direction is not
   of unit length. False, and a ray that hits nothing, where pktrt_render would refuse the camera. */
PKTRT_DEF bool pktrt_camera_ray(const pktrt_camera *, uint32_t width, uint32_t height, double x, double y,
                                const float lens[2], float time, pktrt_ray *ray);

/* >>light ---------------------------------------------------------------------------------------------------------- */

/* How light is counted, each path of it once:
   - The diffuse part of a surface (albedo) gets its light by sampling the lights below, with shadow rays.
   - The specular part (mirror, lobe, glass, metal) sees what its own rays hit: emitting meshes and the environment.
   - Lights that rays cannot hit (point, directional, quad and sphere are not geometry) also show in Phong lobes, by
     the value of the lobe towards them. Ideal mirrors and the camera see quads and spheres that are `visible`, else none.
   - In DRT what a lobe gets of a light with extent is shared between samples of the light and of the lobe, by their
     densities, so that neither narrow lobes nor wide ones are noisy. (Meshes and the environment: if intensity is 1 and
     no texture or shader changes the emission, and parts of the environment are far brighter than its mean; else lobes
     alone find them.)
   - A mesh that emits without being a light is visible, but does not light diffuse surfaces.
   DRT samples quads, spheres and triangles by the solid angle in which they are seen where that is large, the environment
   by cosine and by where it is bright. RCS and WRT send one ray to the middle of a light, and none from within a sphere. A
   mesh counts there as a point, where it is at time 0, with the light of all its triangles, which nothing inside its
   bounding sphere (that of all times) shadows, and the environment as its light from above the surface.
   Shadow rays are stopped by everything, or pass glass: see pktrt_glass_shadows. */
typedef enum pktrt_light_kind {
  PKTRT_LIGHT_POINT = 0,   /* intensity in W/sr: radiance of a white diffuse surface is intensity cos / (pi r^2) */
  PKTRT_LIGHT_DIRECTIONAL, /* intensity is the irradiance (W/m^2) of a surface that faces it */
  PKTRT_LIGHT_QUAD,        /* a parallelogram that shines to the side of cross(edge[0], edge[1]); intensity is its
                               radiance, W/(m^2 sr) */
  PKTRT_LIGHT_SPHERE,      /* intensity is its radiance */
  PKTRT_LIGHT_MESH,        /* the triangles of a mesh, shining from both sides with its material's emission (before any
                               texture); intensity is a factor on it, by channel */
  PKTRT_LIGHT_ENVIRONMENT, /* background or environment of the render, times intensity by channel, from all sides: sky
                               light, ambient occlusion */
  PKTRT_LIGHT_KIND_COUNT
} pktrt_light_kind;
typedef struct pktrt_light {
  pktrt_light_kind kind;
  float position[3];  /* point; centre of a sphere; a corner of a quad */
  float direction[3]; /* directional: the way the light travels; any length but zero */
  float intensity[3]; /* linear RGB, >= 0; its meaning depends on the kind */
  float edge[2][3];   /* quad: from the corner along its sides */
  float radius;       /* sphere, >= 0; a sphere or quad without area gives no light */
  uint32_t mesh;      /* mesh light: the index of a mesh, looked at when rendering */
  /* Quad (from its front) and sphere: rays see it and end there, but it casts no shadow. false: what it lights alone is
     seen, as of what shines beside a camera in a studio. A mesh light is seen by itself. */
  bool visible;
} pktrt_light;
PKTRT_DEF pktrt_status pktrt_add_light(pktrt_scene *, const pktrt_light *, uint32_t *light);

/* >>material ------------------------------------------------------------------------------------------------------- */

/* Glass in glass. Every ray knows which glasses it is in, from the camera on, and the one that it entered last dims it
   (Beer's law), on its way to a surface as on a shadow ray's way to a light. A mesh of glass is best closed: each edge
   with a triangle to either side.
   - Nested: glass within glass is simply put there; ior is relative to what surrounds it, so of water (1.33) in a
     bottle (1.5) it is 1.33 / 1.5. Rays remember the last four glasses (two in scenes of more than 127 materials, one
     beyond 32,767); one that was forgotten is known again where a ray meets its inside.
   - Touching: of faces that coincide a ray meets one, that of the lower mesh, and refracts by its ior alone; both
     glasses are entered or left there.
   - Overlapping: where none contains the other, the one entered last dims, until it is left.
   - Around the camera (and each point of its lens) are closed meshes that it stands in; the smaller one is the inner
     one.
   - Open: sheets, and bodies whose surface is shared out among meshes, as a tumbler's glass, what holds water, and the
     water's own surface (each with the ior of what it parts). A ray leaves one where it enters the next, and what it
     meets from the inside and does not know of was around it: so a sheet dims what is seen through its back. A camera
     is in none. Light that comes from infinitely far, with nothing in between, is not dimmed. */
/* What a surface does besides being diffuse. */
typedef enum pktrt_specular {
  PKTRT_SPECULAR_NONE = 0,
  PKTRT_SPECULAR_MIRROR,     /* reflects `reflectance`, whatever the angle; albedo + reflectance <= 1 */
  PKTRT_SPECULAR_COAT,       /* clear varnish of index ior over the diffuse base: reflects F, lets (1 - F) to the base
                                 (F: exact unpolarised Fresnel reflectance at the angle of view) */
  PKTRT_SPECULAR_DIELECTRIC, /* glass: reflects F, refracts 1 - F, with Beer attenuation inside. Outside is where the
                                 corners appear counter-clockwise. albedo is not used. */
  PKTRT_SPECULAR_CONDUCTOR,  /* metal: Fresnel reflectance of the complex index ior + i extinction; albedo not used */
  PKTRT_SPECULAR_COUNT
} pktrt_specular;

/* Where mirror, coat and conductor reflect to. */
typedef enum pktrt_lobe {
  PKTRT_LOBE_IDEAL = 0, /* the mirror direction */
  PKTRT_LOBE_PHONG      /* around it, with density (exponent + 1) / (2 pi) cos^exponent. What would go below the
                                 surface is lost. WRT follows the mirror direction; lights show a highlight in both. */
} pktrt_lobe;

/* Points of one material, structure of arrays, for the hooks of a material: n values each. What a hook writes must
   depend on the values of each point alone: which points come together changes from setting to setting. */
typedef struct pktrt_points {
  uint32_t n;
  const float *position[3], *direction[3]; /* direction: unit, of the ray that arrived */
  const float *normal[3];                  /* unit shading normal, on the side that the ray came from */
  const float *barycentric[2], *time;      /* u and v of the hit */
  const float *texcoord[2];                /* interpolated; 0 where the mesh has none */
  const uint32_t *mesh, *triangle;
  float *albedo[3], *reflectance[3], *emission[3]; /* as the material has them; a texture changes them */
  float *opacity; /* 1; where the texture of a cutout sets less than a half, there is nothing */
} pktrt_points;

typedef struct pktrt_material { /* a zeroed one is black */
  float albedo[3];              /* linear RGB diffuse reflectance, each in [0,1] */
  pktrt_specular specular;
  float reflectance[3]; /* mirror; each in [0,1]. Elsewhere a factor on what is reflected if any is > 0 */
  float ior[3];         /* coat and dielectric: ior[0], inside over outside; 0: 1.5. Conductor: by channel */
  float extinction[3];  /* conductor, by channel, >= 0 */
  float absorption[3];  /* dielectric: inside, light falls by exp(-absorption * distance); >= 0 */
  pktrt_lobe lobe;
  float exponent;    /* Phong lobe: >= 0 */
  float emission[3]; /* radiance of both sides, >= 0 */
  /* Changes albedo, reflectance, emission; NULL: none. What it writes is not checked: NaN or infinity, here as from a
     shader or an environment, reaches every pixel whose rays come by, and that pixel stays so. */
  void (*texture)(void *user, const pktrt_points *);
  /* Replaces everything else that happens at these points: the radiance towards the viewer, by channel. NULL: none */
  void (*shader)(void *user, const pktrt_points *, float *radiance[3]);
  void *user;  /* handed to both, from any thread */
  bool cutout; /* its texture may make points transparent: all rays of a picture go on there, shadow rays too. A texture
                  is called for each such point of a ray, and once more where the ray ends. Queries see all of a mesh. */
} pktrt_material;
/* *material receives an index from 1 on; 0 is the default, albedo 0.8. */
PKTRT_DEF pktrt_status pktrt_add_material(pktrt_scene *, const pktrt_material *, uint32_t *material);

/* Unpolarised Fresnel reflectance for the cosine of the angle of incidence, [0,1]. Dielectric: eta = index behind the
   surface over index before it; 1 beyond the critical angle. Conductor: index eta and extinction k, relative. */
PKTRT_DEF float pktrt_fresnel_dielectric(float cosine, float eta);
PKTRT_DEF float pktrt_fresnel_conductor(float cosine, float eta, float k);

/* >>sampler -------------------------------------------------------------------------------------------------------- */

/* Counter-based: a value depends on the settings, the pixel, the sample and the dimension alone, in any order and from
   any thread. Nothing depends on the frame: noise stands still unless you change the seed. */
typedef enum pktrt_sampler {
  PKTRT_SAMPLER_SOBOL = 0,   /* Sobol' points, Owen-scrambled, other ones for each pixel; jointly in 4 dimensions, of
                                which i / n is one; best if `samples` is a power of two */
  PKTRT_SAMPLER_RANDOM,      /* independent */
  PKTRT_SAMPLER_JITTERED,    /* one in each cell of a grid, for each pair of dimensions */
  PKTRT_SAMPLER_INTERLEAVED, /* one set for 4 x 4 pixels, each with its own part, repeated (Keller and Heidrich 2001) */
  PKTRT_SAMPLER_HALTON,      /* radical inverses in prime bases, digits scrambled */
  PKTRT_SAMPLER_HAMMERSLEY,  /* the same with i / n as the first dimension */
  PKTRT_SAMPLER_BLUE_NOISE,  /* Sobol' points dealt out along a shuffled Morton curve, so that neighbouring pixels
                                err in opposite ways (Ahmed and Wonka 2020) */
  PKTRT_SAMPLER_COUNT,
  PKTRT_SAMPLER_CUSTOM = PKTRT_SAMPLER_COUNT /* of renders: asks a function of yours, custom_sampler */
} pktrt_sampler;
PKTRT_DEF const char *pktrt_sampler_string(pktrt_sampler); /* "sobol", "random", ...; never NULL */

typedef struct pktrt_sampling {
  pktrt_sampler sampler;
  uint32_t samples; /* per pixel, 1 to 65536: sets are made for this number */
  uint32_t seed;
} pktrt_sampling;
/* Fills out[i] with coordinate `dimension` + i, i < n, of a sample of a pixel: in [0,1). A render uses 0 and 1 for the
   place in the pixel, 2 and 3 for the lens, 4 for the time (without a lens: 2); those of the scattering events follow.
   Dimensions 4k to 4k + 3 belong together, pairs 2k and 2k + 1 most of all. */
PKTRT_DEF void pktrt_sample(const pktrt_sampling *, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                            uint32_t n, float *out);

/* Mappings from the unit square. All keep neighbours together, and the origin maps to no extreme of directions (paper,
   section 4): with the disk, the middle of the square goes to the middle; with directions, u[0] = 0 to the axis. */
PKTRT_DEF void pktrt_map_disk(const float u[2], float out[2]);   /* unit disk, uniform, concentric */
PKTRT_DEF void pktrt_map_sphere(const float u[2], float out[3]); /* unit sphere, uniform */
PKTRT_DEF void pktrt_map_cosine(const float u[2], const float normal[3], float out[3]); /* density cos / pi */
/* Phong lobe around a unit axis; unit direction out. Careful: u = (0,0) maps to within the lobe, every tangent is a
   limit never met. Naive, for comparison: cos = u[0]^(1/(exponent+1)), whose origin is perpendicular to the axis. */
PKTRT_DEF void pktrt_map_phong(const float u[2], const float axis[3], float exponent, float out[3]);
PKTRT_DEF void pktrt_map_phong_naive(const float u[2], const float axis[3], float exponent, float out[3]);

/* >>render --------------------------------------------------------------------------------------------------------- */

typedef enum pktrt_mode {
  PKTRT_MODE_RCS = 0, /* ray casting with shadows: primary rays, one shadow ray per light; every surface is diffuse */
  PKTRT_MODE_WRT,     /* Whitted: reflection and refraction too. Nothing is random but the place in the pixel, if there
                         is more than one sample (and the way at glass, if asked for): lens, shutter, lights and lobes
                         are taken in their middle */
  PKTRT_MODE_DRT      /* distribution ray tracing: lens, shutter, area lights and lobes are sampled */
} pktrt_mode;

typedef enum pktrt_normals {
  PKTRT_NORMALS_SMOOTH = 0, /* interpolated where the mesh has normals */
  PKTRT_NORMALS_GEOMETRIC   /* of the triangle, everywhere */
} pktrt_normals;

typedef enum pktrt_shadow_packets {
  PKTRT_SHADOWS_PER_LIGHT = 0, /* one packet for each light: measured the faster */
  PKTRT_SHADOWS_TOGETHER       /* one packet for all lights of a primary packet */
} pktrt_shadow_packets;

/* How the rays that one packet sends out become packets (paper, section 3.2). Changes no pixel. */
typedef enum pktrt_assembly {
  PKTRT_ASSEMBLY_RAY_TYPES = 0, /* one packet each of shadow, reflection and refraction rays */
  PKTRT_ASSEMBLY_RUNS,          /* of these, those of adjacent rays that met the same material */
  PKTRT_ASSEMBLY_MATERIALS,     /* groups: of these, those that met the same material */
  PKTRT_ASSEMBLY_OCTANTS,       /* groups: of these, those with the same octant of directions */
  PKTRT_ASSEMBLY_BLIND,         /* one packet of all, shadow rays traced like the others */
  PKTRT_ASSEMBLY_NONE /* secondary rays traced and shaded one by one; primary in packets: the paper's table 1 */
} pktrt_assembly;

/* At a dielectric. */
typedef enum pktrt_branching {
  PKTRT_BRANCHING_BY_MODE = 0, /* WRT follows both, DRT chooses; adaptive passes in DRT follow both where a primary ray
                                  ends, if they find that variance times rays is less so: 1% to 4% less noise in rtrt */
  PKTRT_BRANCHING_BOTH,        /* follow reflection and refraction, weighted */
  PKTRT_BRANCHING_CHOOSE,      /* follow one of them, at random, by Fresnel weight: N rays in, N rays out */
  PKTRT_BRANCHING_FIRST        /* follow both where a primary ray ends, choose deeper: 4% less noise in rtrt, in 2% more
                                  time; elsewhere no more than chance */
} pktrt_branching;

/* DRT: which lights a surface asks. */
typedef enum pktrt_light_choice {
  PKTRT_LIGHTS_ALL = 0,
  PKTRT_LIGHTS_ONE_DEEPER, /* all where a primary ray ends; deeper, one at random for all: fewer rays, more noise */
  PKTRT_LIGHTS_ONE         /* one for all everywhere, chosen by power, distance and facing: for scenes of many lights */
} pktrt_light_choice;

typedef enum pktrt_glass_shadows {
  PKTRT_GLASS_SHADOWS_PASS = 0, /* shadow rays go straight on through glass and lose what Fresnel reflection and Beer
                                   attenuation take; not bent, so no caustics. The 102nd surface of glass stops them */
  PKTRT_GLASS_SHADOWS_BLOCK     /* glass is as opaque as anything (RCS: always) */
} pktrt_glass_shadows;

typedef enum pktrt_phong_mapping {
  PKTRT_PHONG_CAREFUL = 0,
  PKTRT_PHONG_NAIVE /* for comparison, see pktrt_map_phong_naive */
} pktrt_phong_mapping;

/* How wrong a picture is by chance. Its passes are complete sets of samples, scrambled independently of each other, so
   the scatter of their means is that of independent replicates; within one set it would mean nothing, since samples of
   a set are spread on purpose. Of a pixel with means x_1 ... x_n (colours) and x their mean, the squared error of x is
   estimated by V = sum |x_i - x|^2 / (n (n - 1)): without bias, coarse for a pixel while n is small (with two passes it
   is off by half of itself or more as often as not), good for a block and a picture, where many pixels are summed.
   (Rules that look at it stop a little early rather than late, for they stop where it is low by chance.)
   What is not counted: what every pass does alike, that is, rays not followed (attenuation, max_depth). */
typedef enum pktrt_error_measure {
  PKTRT_ERROR_RMSE = 0, /* sqrt(mean of V / 3): of a channel, in units of radiance */
  /* Relative MSE: mean over pixels of V / (|b|^2 + |m|^2 / 100), b: mean colour of the pixel's block, m: of the
     picture. (A pixel's own mean in place of b is not known while V is large: bright by chance, it hides its error.) */
  PKTRT_ERROR_RELATIVE
} pktrt_error_measure;
#define PKTRT_ERROR_BLOCK 16 /* pixels along the edge of the blocks that errors are summed over */

/* Why a render ended; where two rules agree, the first of these. */
typedef enum pktrt_stop {
  PKTRT_STOP_NOT_YET = 0,
  PKTRT_STOP_ERROR,    /* the estimate has reached target_error */
  PKTRT_STOP_PASSES,   /* all passes are done, or more would not help: pixels are not finite */
  PKTRT_STOP_TIME,     /* another pass would exceed time_budget */
  PKTRT_STOP_ASKED,    /* the hook `pass` said so */
  PKTRT_STOP_CANCELLED /* the hook `progress` said so, or a tile ran out of memory */
} pktrt_stop;

/* PKTRT_SAMPLER_CUSTOM: returns one coordinate, in [0,1); what is not in there is taken as the nearest that is, NaN as
   0. Called from any thread; must depend on the arguments alone. `seed` is another for each pass. */
typedef float pktrt_custom_sampler(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                   uint32_t seed);

/* For teaching: a packet (fast path: a batch) of a render before it is traced. Rows of n, there during the call. */
typedef struct pktrt_packet {
  pktrt_ray_type type;
  uint32_t depth, n;              /* bounces since the camera: 0 is primary, shadow rays one more than their surface */
  const uint32_t *rays;           /* numbers in the packet that sent them out; primary rays: in their own */
  const uint32_t *x, *y, *sample; /* what the rays add to: pixels, and samples of them, over all passes */
  const float *origin[3], *direction[3];
} pktrt_packet;

/* What `cost` of pktrt_render_desc counts, as pktrt_counts has it. */
typedef enum pktrt_cost {
  PKTRT_COST_BOXES = 0, /* lanes */
  PKTRT_COST_TRIANGLES, /* lanes */
  PKTRT_COST_VECTORS    /* paper path: tests of eight lanes, against boxes or triangles */
} pktrt_cost;

typedef struct pktrt_report { /* after whole rounds of passes: one over the picture, or if adaptive over parts of it */
  uint32_t rounds;
  uint32_t samples_min, samples_max; /* of a pixel */
  double samples_mean;
  double rmse, relative_mse; /* estimated, see pktrt_error_measure; INFINITY while a pixel has had one pass only */
  /* How far these can be believed. Of both, by pktrt_error_measure: pixels that carry the estimate, (sum V)^2 / sum V^2
     (0: there is no error); whether it should not be believed, for it may be off by a quarter (of the RMSE) or more, or
     fewer than 8 passes have been made and less than an eighth of the pixels carry it. Bounds that hold the true error
     95 times of 100, if what is rare has been seen: nobody knows of light that no sample has met. */
  double effective_pixels[2];
  bool unreliable[2];
  double rmse_low, rmse_high, relative_mse_high;
  uint64_t unknown; /* pixels whose estimate is not finite, left out of both */
  double seconds;   /* since the call */
  pktrt_stop stop;
} pktrt_report;

typedef struct pktrt_render_desc {
  uint32_t width, height; /* of the whole picture, pixels; up to 65536 each */
  float *pixels;          /* linear RGB, row 0 at the top */
  size_t row_stride;      /* floats from row to row; 0: width * 3 */
  pktrt_mode mode;
  pktrt_camera camera;
  float background[3]; /* radiance where a ray meets nothing */
  float ambient[3];    /* radiance added to every surface point as albedo * ambient */
  pktrt_normals normals;
  uint32_t packet_size; /* rays along a packet's edge: 2, 4, 8 or 16; 0: 8. The fast path forms packets of its own;
                                  there it only says in which order pixels are taken */
  uint32_t tile_size;   /* pixels along a tile's edge, 1 to 1024; 0: 64 */
  pktrt_path path;
  pktrt_shadow_packets shadows;
  /* NULL: count nothing, at no cost (the paper path always counts). Who counts, or has `packet` called, gets reflected
     and refracted rays traced apart, which the fast path else traces together. */
  pktrt_stats *stats;
  /* Called after tiles and, within those that take long, every 256 packets of rays, from the thread at work, so perhaps
     from several at once; done in [0,1], not always in order. false cancels. NULL: none. */
  bool (*progress)(void *user, float done);
  void *user;

  uint32_t samples; /* per pixel and pass, 1 to 65536; 0: 1. Alone in its pixel it lies in the middle, save in DRT */
  pktrt_sampler sampler;
  uint32_t seed;
  uint32_t max_depth; /* generations of secondary rays, up to 50 (PKTRT_MAX_DEPTH); 0: 50 */
  /* Ray tree attenuation: a ray that could add less than this fraction to its sample is not followed, and nothing is
     put in its place: pictures get darker, by less than this times the radiance of what is not seen, for every ray cut
     off. [0,1]; 0: 1/256. Negative: off; where glass branches, a sample then costs up to 2^max_depth rays. */
  float attenuation;
  pktrt_assembly assembly;
  pktrt_branching branching;
  pktrt_light_choice lights;
  pktrt_glass_shadows glass_shadows;
  pktrt_phong_mapping phong_mapping;
  /* Radiance from directions where rays meet nothing, n at a time, in place of background; direction is of unit
     length. Called from any thread, and must depend on the direction alone. NULL: background. */
  void (*environment)(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]);
  /* Optional buffers, tight, row 0 at the top; NULL: none. Means over all passes' samples of what primary rays meet. */
  float *depth;           /* distance from the lens, of the samples that met something; INFINITY where none did */
  float *normal;          /* three floats, unit shading normals towards the viewer, averaged; 0 for nothing */
  float *albedo;          /* three floats, diffuse reflectance; 0 for glass and metal, unless in RCS */
  uint32_t *sample_count; /* samples that a pixel has had */
  /* Work per sample: that of a packet is shared out evenly among its rays, so the finer the smaller packet_size, which the
     fast path keeps to where cost is asked for. Differs by path and instruction set, as counts do. */
  float *cost;
  pktrt_cost cost_of;
  /* Called for each packet before it is traced, from any thread; blindly, a packet is halved above 128 rays. Shadow rays
     on their way behind glass are not told of. Where the fast path has reflected and refracted rays in one wave, they
     are told apart, but numbered on when they send out rays. NULL: none. */
  void (*packet)(void *user, const pktrt_packet *);
  /* Paper path: called for each event of packets with rays that add to pixels in trace_area, from the thread that has told
     `packet` of them: x, y, width and height, all 0 for the whole picture. NULL: none. */
  void (*trace)(void *user, const pktrt_event *);
  uint32_t trace_area[4];
  uint32_t paper_steps;                 /* bits of pktrt_paper_step; 0: all */
  pktrt_custom_sampler *custom_sampler; /* for PKTRT_SAMPLER_CUSTOM */

  /* Passes, each with `samples` samples per pixel, until the first of these rules says stop. They cost 42 bytes per
     pixel; estimates, made if asked for below, need two passes. The picture (and each buffer) is whole after each. */
  uint32_t passes; /* at most, up to 65536; 0: 1, or if there is another rule, 65536 */
  /* Stops when the estimate is not above it; 0: no such rule. It is not met while pixels are not finite (by a hook's
     NaN, say): when all others meet it, such a render ends as if its passes were done. An unreliable estimate (see
     pktrt_report) does not meet it: from 8 passes on the upper bound is compared instead. */
  float target_error;
  bool trust_estimates;        /* the estimate meets it whether reliable or not */
  pktrt_error_measure measure; /* what target_error is compared with, and adaptive passes lower */
  double time_budget;          /* seconds; the first pass (adaptive: two) is always done, others if they should fit, as
                                  those before took. What is done by then depends on the machine. 0: no such rule */
  /* Gives passes to cells of 4 x 4 pixels by their estimated error: two to all of them, then in rounds where they lower
     the picture's error most. `passes` is a mean over pixels then, to within 0.1 or a pass of one cell, whichever is
     more. Where rare light has been seen it is diluted by further passes, where not, not: means are low by part of
     their error (built-in scenes, 16 passes of 8 samples: by 0.1 to 0.6% of the mean), and so are estimates, the more
     the rarer light is. Uniform passes have no such bias. */
  bool adaptive;
  /* Called after each round, from the calling thread; false: stop, which is no failure. NULL: none. */
  bool (*pass)(void *user, const pktrt_report *);
  pktrt_report *report; /* NULL: not wanted */
  float *pixel_error;   /* sqrt(V / 3) of each pixel, tight, row 0 at the top; INFINITY for one pass. Both are
                                  left alone if the render fails or is cancelled */
  float *block_error;   /* sqrt(mean of V / 3) over each PKTRT_ERROR_BLOCK^2 pixels, from the top left corner on,
                                  INFINITY if none is known; those at the right and lower edge may be cut off */
  double (*seconds)(void *user); /* a clock, for time_budget and report; NULL: the system's */
} pktrt_render_desc;

/* Renders the whole picture, tile by tile through parallel_for. Meshes, but none committed: PKTRT_NOT_COMMITTED. What
   is likely to be a mistake, it says once through `log`: that there is no light and no ambient, that the mode takes no
   notice of what the scene or the camera has, that a mesh has changed since the last commit or refit. Same bits for any
   number of workers, tile size, packet size, path and instruction set (time_budget: for the passes that were done).
   PKTRT_CANCELLED: progress said so; parts of the first pass may be missing, later ones may lack a pass. */
PKTRT_DEF pktrt_status pktrt_render(pktrt_scene *, const pktrt_render_desc *);

/* Renders the pixels [x, x+w) x [y, y+h) of the picture that desc describes, into their place in desc->pixels.
   Thread-safe on a committed scene as long as tiles do not overlap and desc->stats is not shared. Makes as many passes
   as desc->passes says; a tile knows no picture's error, so all else that passes bring is refused. Does not call
   progress and leaves no detail; pktrt_render gives one. Lights that are meshes, and glass, are looked through anew for
   each call: let tiles be large where these are. */
PKTRT_DEF pktrt_status pktrt_render_tile(const pktrt_scene *, const pktrt_render_desc *, uint32_t x, uint32_t y,
                                         uint32_t w, uint32_t h);

/* To make a picture's passes in several places, processes or machines, with the bits of pktrt_render. The three of them
   take a desc that pktrt_render would take, with its rules, but adaptive, time_budget and the optional buffers of what
   primary rays meet, cost and sample_count are refused; progress and `pass` are not called. */

/* Renders one pass, the first is 0, over the pixels [x, x+w) x [y, y+h), and writes the means of its samples: three
   doubles for each pixel, tight, row by row. pixels is left alone, and may be NULL. Else as pktrt_render_tile. */
PKTRT_DEF pktrt_status pktrt_render_pass(const pktrt_scene *, const pktrt_render_desc *, uint32_t pass, uint32_t x,
                                         uint32_t y, uint32_t w, uint32_t h, double *means);

/* What a pixel has had: the sum of its passes' means, and that of their squares over all channels. All zero at first. */
typedef struct pktrt_pixel_sums {
  double mean[3], squares;
} pktrt_pixel_sums;

/* Adds a pass to the sums of n pixels that follow each other. Bits are those of pktrt_render if each pixel gets its
   passes one after the other, from the first on; pixels may be at different passes. */
PKTRT_DEF void pktrt_add_pass(const double *means, size_t n, pktrt_pixel_sums *);

/* Makes of the whole picture's sums, tight, each of as many passes, what pktrt_render has then: pixels, report (but
   seconds: 0), pixel_error, block_error. Whether the rules end the render, report->stop says; if not, another pass over
   all pixels is to be made. What is in the scene does not matter. */
PKTRT_DEF pktrt_status pktrt_finish_passes(pktrt_scene *, const pktrt_render_desc *, uint32_t passes,
                                           const pktrt_pixel_sums *);

/* Looks at desc->environment in some 500,000 directions and keeps where it is bright, for all further renders and tiles of
   the scene with the same function and user. Else every render with a PKTRT_LIGHT_ENVIRONMENT in DRT does so for itself
   (if it takes less than 16,384 samples, in 32,000). It says where samples go, not what they bring: pictures are without
   bias whatever it is, and the better the fresher it is. NULL as environment forgets it. Not while renders of the scene
   are under way. */
PKTRT_DEF pktrt_status pktrt_prepare_environment(pktrt_scene *, const pktrt_render_desc *);

#endif /* PKTRT_NO_RENDER */

#ifdef __cplusplus
}
#endif

/* stop here if you only want the API */
#endif /* PKTRT_H */
/* >>life: the life of a ray ------------------------------------------------------------------------------------------

   In a picture, from pktrt_render to a pixel:

     pktrt_render         checks the description (>>request) into a pktrt__render_state, which every tile reads, and
                          finds out what is to be known of lights (>>lights) and glass (>>glass).
     pktrt__pass_run      goes round by round (>>passes), tile by tile through parallel_for, each with its own
                          pktrt__tile.
     pktrt__tile_render_block lists the samples of a block of pixels (>>tiles),
     pktrt__tile_run_wave and fills a pktrt__wave with their rays; a lane of it is the ray from now on.
     pktrt__wave_trace    hands the pktrt__batch of the wave to kernels->trace, which is
     pktrt__entry_trace   of an instruction set: it derives what traversal needs (>>setup); pktrt__drive_fast (>>drive)
                          then takes coherent rays by frusta, others in streams by octant, few one by one. Hits stay in
                          the batch: as `slot`, a lane of a leaf block, until >>resolve finds t, u, v and normal.
     pktrt__wave_shade    packs the lanes that hit something into pktrt__surfaces (pktrt__surface_gather, which gives
                          the others the background), evaluates their materials (>>shade, >>materials), sends shadow
                          rays to lights, whose light pktrt__packet_flush adds (>>direct, >>assembly), spawns reflected
                          and refracted rays into waves of the next generation (>>scattering), and ends in
     pktrt__wave_follow   which has these traced and shaded, generation by generation, and adds what they bring to the
                          lanes that sent them (>>generations).
     pktrt__tile_write_pixels divides what pktrt__tile_run_wave has added up for each pixel.

   In a query, from pktrt_intersect_n to a hit: pktrt__query_run takes few rays one by one (kernels' intersect), many by
   batches (pktrt__query_run_batches): load_rays transposes up to 256 of them to a pktrt__batch (>>arrays), trace is
   pktrt__entry_trace as above, store_hits transposes the hits back. */

/* >>extend: how to add what is not there -----------------------------------------------------------------------------

   - A light: an enumerator of pktrt_light_kind, a row of PKTRT__LIGHT_ROWS (>>kinds) with its traits, a prototype there,
     and the function (>>lights) that takes a point of it; another that prepares it, if none there does; and one that finds
     the point in a direction, if it has an extent but is nothing that rays hit. Checks and reports follow
     from the traits. RCS and WRT see a light as its middle: give it the trait EACH if that will not do, FLAT if it has a front.
   - A material: an enumerator of pktrt_specular and a row of PKTRT__SPECULAR_ROWS (>>kinds); then the weights of its
     rays, in pktrt__material_weights8 (>>shade). Without these it reflects nothing.
   - A sampler: an enumerator of pktrt_sampler, a row of PKTRT__SAMPLER_ROWS and a prototype (>>kinds), and its function
     (>>samplers).
   - A feature that builds can leave out: an enumerator of pktrt_feature and a row of PKTRT__FEATURE_ROWS (>>platform),
     by which PKTRT__X is 1 or 0 for all code that asks; and in pktrt__feature_of_render what asks for it (>>request).
   - An instruction set: an enumerator of pktrt_isa; PKTRT__HAS_X (>>platform); PKTRT__STAMP_X and a stamp (>>stamping);
     its operations and, as PKTRT__WITH_..., what it is good at (>>ops); its name, its tables and its rank (>>dispatch).
     No kernel changes.
   That each kind of light, material and sampler has a row, and in the order of its enumeration, is checked at compile
   time, and so are the names of instruction sets. */

/* ---------------------------------------------------------------------------------------------------------------------
   IMPLEMENTATION, compiled once
   ------------------------------------------------------------------------------------------------------------------ */
#ifdef PKTRT_IMPLEMENTATION
#ifndef PKTRT__IMPLEMENTED
#define PKTRT__IMPLEMENTED

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h> /* vsnprintf, for error sentences */
#include <stdlib.h>
#include <string.h>

/* >>platform ------------------------------------------------------------------------------------------------------- */

#if defined(PKTRT_NO_RENDER) != defined(PKTRT__DECLARED_NO_RENDER)
#error "PKTRT_NO_RENDER: define it before the first time that a file includes pktrt.h, or not at all"
#elif defined(PKTRT_NO_NORMALS) != defined(PKTRT__DECLARED_NO_NORMALS)
#error "PKTRT_NO_NORMALS: define it before the first time that a file includes pktrt.h, or not at all"
#elif defined(PKTRT_NO_REMOVAL) != defined(PKTRT__DECLARED_NO_REMOVAL)
#error "PKTRT_NO_REMOVAL: define it before the first time that a file includes pktrt.h, or not at all"
#elif defined(PKTRT_NO_INSTANCES) != defined(PKTRT__DECLARED_NO_INSTANCES)
#error "PKTRT_NO_INSTANCES: define it before the first time that a file includes pktrt.h, or not at all"
#elif defined(PKTRT_NO_SURFACES) != defined(PKTRT__DECLARED_NO_SURFACES)
#error "PKTRT_NO_SURFACES: define it before the first time that a file includes pktrt.h, or not at all"
#elif defined(PKTRT_STATIC) != defined(PKTRT__DECLARED_STATIC)
#error "PKTRT_STATIC: define it before the first time that a file includes pktrt.h, or not at all"
#endif
/* The file with the implementation must be compiled without flags that change values. Those that no macro reveals,
   above all with clang, are forbidden by the guard below or found by pktrt__check_all_arithmetic. */
#if defined(__FAST_MATH__)
#error "pktrt.h needs IEEE arithmetic: drop -ffast-math (-Ofast includes it)"
#elif defined(_M_FP_FAST)
#error "pktrt.h needs IEEE arithmetic: drop /fp:fast"
#elif defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error "pktrt.h needs NaN and infinities: drop -ffinite-math-only"
#elif defined(__ASSOCIATIVE_MATH__)
#error "pktrt.h needs sums in their order: drop -fassociative-math, -funsafe-math-optimizations and -ffast-math"
#elif defined(__RECIPROCAL_MATH__)
#error "pktrt.h needs true division: drop -freciprocal-math, -funsafe-math-optimizations and -ffast-math"
#elif defined(__NO_SIGNED_ZEROS__)
#error "pktrt.h needs the sign of zeros: drop -fno-signed-zeros"
#endif
#if defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0 && \
    FLT_EVAL_METHOD != 16 /* 16: as 0, where there is half precision */
#error \
    "pktrt.h needs float arithmetic in float: drop -mfpmath=387; with -msse2 -mfpmath=sse (32-bit x86), -fexcess-precision=fast (s390x)"
#endif

#if defined(__GNUC__) || defined(__clang__)
/* WHY __unused__: where parts are left out, some helpers have no caller. */
#define PKTRT__INLINE static inline __attribute__((__always_inline__, __unused__))
#define PKTRT__NOINLINE static __attribute__((__noinline__, __unused__))
#define PKTRT__COLD static __attribute__((__cold__, __noinline__, __unused__)) /* checks: small rather than fast */
#define PKTRT__ALIGN64 __attribute__((__aligned__(64)))
#define PKTRT__UNLIKELY(x) __builtin_expect(!!(x), 0)
#define PKTRT__PREFETCH(p) __builtin_prefetch(p)
#else
#define PKTRT__INLINE static inline
#define PKTRT__NOINLINE static
#define PKTRT__COLD static
#define PKTRT__ALIGN64
#define PKTRT__UNLIKELY(x) (x)
#define PKTRT__PREFETCH(p) (void)(p)
#endif

/* Marks functions that divide by zero on purpose, as IEEE 754 defines it: the reciprocal of a zero component of a
   direction is an infinity, and unused lanes hold anything. Without the mark UBSan may report scalar divisions. */
#if defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 8)
#define PKTRT__DIVIDES_BY_ZERO __attribute__((__no_sanitize__("float-divide-by-zero")))
#else
#define PKTRT__DIVIDES_BY_ZERO
#endif

/* The compiler must compute what is written: sums in their order, divisions that divide, products and sums rounded
   separately. The same bits on every instruction set depend on it. One guard, opened here and closed at the end, covers
   all of it, and intrinsics first included here; pktrt__check_all_arithmetic finds what it cannot prevent. */
#if defined(__clang__)
#if __clang_major__ >= 13 && (defined(__x86_64__) || defined(__i386__)) /* clang 14 has no other that knows it */
#define PKTRT__FLOAT_CONTROL 1
#pragma float_control(push)
#pragma float_control(precise, on)
#endif
#pragma STDC FP_CONTRACT OFF
#endif

/* The instruction sets of this build. Wide vectors need per-function targets; MinGW may misalign spills of them (GCC
   bug 54412), so there the 16-byte set is the widest. */
#ifndef PKTRT_NO_SCALAR
#define PKTRT__HAS_SCALAR 1
#endif
#if defined(PKTRT_NO_SIMD) || defined(__TINYC__)
#elif (defined(__x86_64__) || defined(__i386__)) && defined(__SSE2__)
#define PKTRT__X86 1
#ifndef PKTRT_NO_SSE2
#define PKTRT__HAS_SSE2 1
#endif
#if !defined(__MINGW32__) || defined(__clang__)
#ifndef PKTRT_NO_AVX2
#define PKTRT__HAS_AVX2 1
#endif
#if !defined(PKTRT_NO_AVX512)
#define PKTRT__HAS_AVX512 1
#endif
#endif
#if defined(__GNUC__) && !defined(__clang__) && defined(__cplusplus)
/* g++ 12 warns of its own intrinsics headers, which initialise "undefined" vectors by themselves (GCC bug 105593). */
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include <immintrin.h>
#include <cpuid.h>
#elif defined(__aarch64__) && defined(__ARM_NEON)
#define PKTRT__HAS_NEON 1
#include <arm_neon.h>
#elif defined(__wasm_simd128__)
#define PKTRT__HAS_WASM 1
#include <wasm_simd128.h>
#endif
/* There are vectors on all machines that this build runs on. */
#if defined(PKTRT__HAS_SSE2) || defined(PKTRT__HAS_NEON) || defined(PKTRT__HAS_WASM)
#define PKTRT__HAS_BASE 1
#endif
#if defined(PKTRT_NO_SCALAR) && defined(PKTRT_NO_SIMD)
#error "PKTRT_NO_SCALAR and PKTRT_NO_SIMD leave no kernels: define only one of them"
#elif !defined(PKTRT__HAS_SCALAR) && !defined(PKTRT__HAS_BASE) && !defined(PKTRT__HAS_AVX2) && \
    !defined(PKTRT__HAS_AVX512)
#error "PKTRT_NO_SCALAR: no other kernels are left for this machine; define it only where vectors stay"
#endif

/* Features: enumerator, name, the switch that leaves it out, and that of what it is a part of. From each row come a
   constant, PKTRT__MOTION, 1 or 0, so that compilers drop what is left out; a bit of PKTRT__BUILT; and a name. */
#define PKTRT__FEATURE_ROWS(ROW)                                         \
  ROW(MOTION, "motion", PKTRT_NO_MOTION, PKTRT_NO_MOTION)                \
  ROW(STATS, "stats", PKTRT_NO_STATS, PKTRT_NO_STATS)                    \
  ROW(PAPER, "paper path", PKTRT_NO_PAPER, PKTRT_NO_PAPER)               \
  ROW(RENDER, "render", PKTRT_NO_RENDER, PKTRT_NO_RENDER)                \
  ROW(MIRROR, "mirror", PKTRT_NO_RENDER, PKTRT_NO_RENDER)                \
  ROW(DIELECTRIC, "dielectric", PKTRT_NO_DIELECTRIC, PKTRT_NO_RENDER)    \
  ROW(CONDUCTOR, "conductor", PKTRT_NO_CONDUCTOR, PKTRT_NO_RENDER)       \
  ROW(GLOSS, "gloss", PKTRT_NO_GLOSS, PKTRT_NO_RENDER)                   \
  ROW(NORMALS, "normals", PKTRT_NO_NORMALS, PKTRT_NO_NORMALS)            \
  ROW(TEXTURES, "textures", PKTRT_NO_TEXTURES, PKTRT_NO_RENDER)          \
  ROW(AREA_LIGHTS, "area lights", PKTRT_NO_AREA_LIGHTS, PKTRT_NO_RENDER) \
  ROW(LENS, "lens", PKTRT_NO_LENS, PKTRT_NO_RENDER)                      \
  ROW(SHUTTER, "shutter", PKTRT_NO_SHUTTER, PKTRT_NO_RENDER)             \
  ROW(INSTANCES, "instances", PKTRT_NO_INSTANCES, PKTRT_NO_INSTANCES)    \
  ROW(GROUPS, "groups", PKTRT_NO_GROUPS, PKTRT_NO_GROUPS)                \
  ROW(REMOVAL, "removal", PKTRT_NO_REMOVAL, PKTRT_NO_REMOVAL)            \
  ROW(SURFACES, "surfaces", PKTRT_NO_SURFACES, PKTRT_NO_SURFACES)
#if defined(PKTRT_NO_INSTANCES) && defined(PKTRT_NO_GROUPS)
#define PKTRT__NO_TOP /* no tree above others */
#endif
/* A macro that is not defined stands for itself: for a text as long as its name. */
#define PKTRT__TEXT_OF(x) #x
#define PKTRT__IS_DEFINED(x, name) (sizeof PKTRT__TEXT_OF(x) != sizeof name)
#define PKTRT__FEATURE_CONSTANT(id, name, without, part_of) \
  PKTRT__##id = PKTRT__IS_DEFINED(without, #without) || PKTRT__IS_DEFINED(part_of, #part_of) ? 0 : 1,
#define PKTRT__FEATURE_BIT(id, name, without, part_of) (int)PKTRT__##id *(int)PKTRT_FEATURE_##id |
enum { PKTRT__FEATURE_ROWS(PKTRT__FEATURE_CONSTANT) };
enum {
  PKTRT__SPECULAR = (int)PKTRT_FEATURE_MIRROR | (int)PKTRT_FEATURE_DIELECTRIC | (int)PKTRT_FEATURE_CONDUCTOR,
  PKTRT__BUILT = PKTRT__FEATURE_ROWS(PKTRT__FEATURE_BIT) 0
};

/* Stops compilation where a condition does not hold. */
#define PKTRT__STATIC_ASSERT(name, condition) typedef char pktrt__assert_##name[(condition) ? 1 : -1]

#if defined(_MSC_VER) && !defined(__clang__)
#pragma fp_contract(off)
#endif
/* The guard for gcc. It stands behind the intrinsics, which a program also includes for its own code. */
#if defined(__GNUC__) && !defined(__clang__) && !defined(__TINYC__)
#pragma GCC push_options
#pragma GCC optimize("fp-contract=off")
/* WHY no-ipa-ra: where gcc 12 knows a callee's registers it omits the vzeroupper before the call, and code compiled for
   SSE waits 170 ns after 512-bit vectors; and at -Os scalar kernels lost values across calls, and with them hits. */
#pragma GCC optimize("no-ipa-ra")
#endif

#ifdef __cplusplus
#define PKTRT__CAST(type, p) static_cast<type>(p)
#else
#define PKTRT__CAST(type, p) ((type)(p))
#endif

/* >>limits --------------------------------------------------------------------------------------------------------- */

/* WHY eight, everywhere, written as 8: a node has eight children, a leaf block eight triangles, and the vector that
   serves both has eight lanes on every instruction set, in one register or in several. So one tree serves all of them.
   */
enum {
  PKTRT__MAX_DEPTH =
      38, /* of the binary tree, hence of the wide one; queries have 64 KiB for two walks, one in the other */
  PKTRT__STACK = PKTRT__MAX_DEPTH * (8 - 1) + 1, /* entries that a depth-first walk can hold */
  PKTRT__NOTES = 8                               /* rays of a stream that are noted at a time: more gain nothing */
};

/* A child reference: PKTRT__LEAF | block, or the index of a node, or PKTRT__EMPTY. */
#define PKTRT__LEAF 0x80000000u
#define PKTRT__EMPTY 0xFFFFFFFFu
/* Beside a triangle's index in pktrt__bvh.block_triangles: another block has it, too. */
#define PKTRT__AGAIN 0x80000000u
/* Bounds of an empty child: finite, so that interpolation in time makes no NaN of them; beyond PKTRT_MAX_COORD. */
#define PKTRT__FAR 1.0e32f

/* >>structures ----------------------------------------------------------------------------------------------------- */

/* A BVH node with the planes of its first key; 64-byte aligned. Those of further keys follow it, 192 bytes each. */
typedef struct pktrt__node {
  float plane[6][8]; /* lo x, hi x, lo y, hi y, lo z, hi z of eight children; empty ones have lo = FAR, hi = -FAR */
  uint32_t child[8]; /* references; at the build the last ones were the likeliest to hold a hit */
  uint32_t order[8]; /* for each octant of ray directions (bit a: component a negative): the children from far to near
                         by the middle of their boxes, three bits each, the farthest in the lowest bits */
} pktrt__node;

/* A leaf block of up to eight triangles, likewise: the vertices of further keys follow it, 288 bytes each. */
typedef struct pktrt__block {
  float vertex[3][3][8]; /* [corner][axis][lane], raw, so that shared vertices have equal bits */
  uint32_t id[8]; /* global triangle index; PKTRT_NONE in lanes without a triangle, or whose triangle has no area at
                            any time: never hit, and back in place when a refit gives it area */
} pktrt__block;

enum {
  PKTRT__NODE_BYTES = sizeof(pktrt__node),
  PKTRT__BLOCK_BYTES = sizeof(pktrt__block),
  PKTRT__NODE_KEY_BYTES = 6 * 8 * sizeof(float),
  PKTRT__BLOCK_KEY_BYTES = 3 * 3 * 8 * sizeof(float)
};

typedef struct pktrt__mesh {
  float *positions; /* key_count * vertex_count * 3, committed */
  float *normals;   /* the same shape, or NULL */
  float *texcoords; /* vertex_count pairs, or NULL */
  float *pending;   /* as positions, from the first set_positions on; taken over by the next commit or refit */
  float *pending_normals;
  uint32_t *indices; /* triangle_count * 3, or NULL for a soup */
  uint32_t vertex_count, triangle_count, key_count, stride, material;
  uint32_t first_id; /* global index of triangle 0 */
  uint32_t instance; /* 1 more than that of the instance which it belongs to: it has no key, nor arrays of its own */
  uint32_t set;      /* of meshes, that it belongs to; PKTRT_NONE: none, for an instance has its trees elsewhere */
  bool committed, dirty, dirty_normals;
  bool marked;       /* the next commit rebuilds its tree */
  bool hide, hidden; /* as the next commit or refit will have it; as its tree has it */
  bool gone, free;   /* the next commit removes it; there is none: the index waits for another */
} pktrt__mesh;

/* Meshes that share a tree: those of one group, number of keys and mask. */
typedef struct pktrt__set {
  uint32_t group, key_count, mask;
  uint32_t first_mesh, end_mesh, meshes; /* its meshes are among these, and so many; none: the set waits for others */
  uint32_t tree;                         /* committed; PKTRT_NONE: none */
  /* What a commit or a refit finds: triangles of the next state, its tree there; whether this must be built or fitted, and
     whether some of it is hidden then. */
  uint32_t triangles, next;
  bool changed, moved, hides;
} pktrt__set;

/* The run of nodes and blocks that one task of the build writes; refit has the same tasks. */
typedef struct pktrt__bvh_task {
  uint32_t first_node, node_count, first_block, block_count;
} pktrt__bvh_task;

/* One segment of a BVH's motion: all that kernels know of the BVH. */
typedef struct pktrt__bvh_segment {
  const struct pktrt__bvh *bvhs;
  const unsigned char *nodes, *blocks;
  size_t node_bytes, block_bytes;
  size_t plane0, plane1, vertex0, vertex1; /* where the segment's two keys lie in a node and in a block, in bytes */
  uint32_t bvh;
} pktrt__bvh_segment;

/* The tree over a set of meshes. Static meshes never pay for moving ones. */
typedef struct pktrt__bvh {
  uint32_t set, mask; /* mask: queries with none of its bits pass by */
  uint32_t key_count, node_count, block_count, task_count;
  uint32_t node_bytes, block_bytes; /* with all keys */
  uint32_t triangle_count, degenerate_count;
  unsigned char *nodes, *blocks; /* see pktrt__bvh_node. Node 0 is the root; a child's index is above its parent's */
  uint32_t *block_triangles;     /* block_count * 8 global indices, those without area included; with PKTRT__AGAIN, of
                                    triangles that another block has without */
  pktrt__bvh_task *tasks;        /* disjoint subtrees; the nodes above them come first */
  float lo[3], hi[3];            /* over all keys */
  bool split;                    /* while it is built: planes of leaves are there, of parts of triangles */
  double sah_at_build, sah_now, area;
  pktrt__bvh_segment rest; /* the first segment, the only one of a tree at rest; set with the scene's bounds */
} pktrt__bvh;

/* Returns where the values of a key lie in a node, in bytes. */
PKTRT__INLINE size_t pktrt__node_key_offset(uint32_t key) {
  return key ? PKTRT__NODE_BYTES + (size_t)(key - 1) * PKTRT__NODE_KEY_BYTES : 0;
}
/* Returns where the values of a key lie in a block, in bytes. */
PKTRT__INLINE size_t pktrt__block_key_offset(uint32_t key) {
  return key ? PKTRT__BLOCK_BYTES + (size_t)(key - 1) * PKTRT__BLOCK_KEY_BYTES : 0;
}

/* Returns a node or a block of a BVH, and the values of one key of either: planes [6][8], vertices [3][3][8]. */
PKTRT__INLINE pktrt__node *pktrt__bvh_node(const pktrt__bvh *bvh, uint32_t node) {
  return PKTRT__CAST(pktrt__node *, PKTRT__CAST(void *, bvh->nodes + (size_t)node * bvh->node_bytes));
}
PKTRT__INLINE pktrt__block *pktrt__bvh_block(const pktrt__bvh *bvh, uint32_t block) {
  return PKTRT__CAST(pktrt__block *, PKTRT__CAST(void *, bvh->blocks + (size_t)block * bvh->block_bytes));
}
PKTRT__INLINE float *pktrt__node_planes(pktrt__node *node, uint32_t key) {
  return PKTRT__CAST(float *,
                     PKTRT__CAST(void *, PKTRT__CAST(char *, PKTRT__CAST(void *, node)) + pktrt__node_key_offset(key)));
}
PKTRT__INLINE float *pktrt__block_vertices(pktrt__block *block, uint32_t key) {
  return PKTRT__CAST(
      float *, PKTRT__CAST(void *, PKTRT__CAST(char *, PKTRT__CAST(void *, block)) + pktrt__block_key_offset(key)));
}

/* Returns a node, a block or their values to kernels, at the first key (which = 0) or the second (1) of a segment.
   `moving` is a constant: at rest nothing is looked up. */
PKTRT__INLINE const pktrt__node *pktrt__segment_node(const pktrt__bvh_segment *seg, uint32_t node, const bool moving) {
  const unsigned char *at = seg->nodes + node * (moving ? seg->node_bytes : (size_t)PKTRT__NODE_BYTES);
  return (const pktrt__node *)(const void *)at;
}
PKTRT__INLINE const pktrt__block *pktrt__segment_block(const pktrt__bvh_segment *seg, uint32_t block,
                                                       const bool moving) {
  const unsigned char *at = seg->blocks + block * (moving ? seg->block_bytes : (size_t)PKTRT__BLOCK_BYTES);
  return (const pktrt__block *)(const void *)at;
}
PKTRT__INLINE const float *pktrt__segment_planes(const pktrt__bvh_segment *seg, const pktrt__node *node,
                                                 const int which, const bool moving) {
  const size_t at = !moving ? 0 : which ? seg->plane1 : seg->plane0;
  return (const float *)(const void *)((const unsigned char *)(const void *)node + at);
}
PKTRT__INLINE const float *pktrt__segment_vertices(const pktrt__bvh_segment *seg, const pktrt__block *block,
                                                   const int which, const bool moving) {
  const size_t at = !moving ? 0 : which ? seg->vertex1 : seg->vertex0;
  return (const float *)(const void *)((const unsigned char *)(const void *)block + at);
}

/* How an instance lies at a time: a point p of its model is at a p + shift. */
typedef struct pktrt__place {
  double inverse[4][4], shift[4]; /* by columns, and then its diagonal; the fourth of each is 0 */
  double a[3][3];
  bool straight; /* a has a diagonal only, at all keys */
} pktrt__place;
typedef struct pktrt__instance {
  const pktrt_scene *model;
  float *keys, *pending; /* key_count * 12; as positions of meshes */
  uint32_t key_count, first_mesh, first_id;
  uint32_t mask, seen;          /* seen: the mask as committed, 0 where hidden */
  bool dirty, hide, gone, free; /* as of meshes; one that is free keeps model and indices */
  double kappa;                 /* of the keys that were given, see >>places */
  pktrt__place rest;            /* at the first key, committed */
} pktrt__instance;

enum { PKTRT__STARTS = 64 };
struct pktrt_scene {
  pktrt_scene_desc desc;
  pktrt_isa isa;
  const struct pktrt__kernel_table *kernels;
  pktrt__mesh *meshes;
  uint32_t mesh_count, mesh_capacity, committed_meshes;
  uint32_t start_shift, starts[PKTRT__STARTS + 1]; /* the mesh of each 2^start_shift-th global triangle index */
  uint32_t free_meshes;                            /* indices that any mesh may have anew */
  pktrt__set *sets;
  uint32_t set_count, set_capacity;
  pktrt__bvh *bvhs; /* first those that all rays visit, in ascending order of their boxes' areas: small ones shorten
                       rays for the large; then those under a tree of their boxes */
  uint32_t bvh_count, bvh_room, direct_count;
  pktrt_scene
      *groups; /* that tree: a mesh for each tree under it, of one triangle across its box at each key; or NULL */
#ifndef PKTRT_NO_RENDER
  pktrt_material plain; /* for meshes that name none */
  pktrt_material *materials;
  uint32_t material_count, material_capacity;
  pktrt_light *lights;
  uint32_t light_count, light_capacity;
  struct pktrt__environment *environment; /* prepared by pktrt_prepare_environment; or NULL */
#endif
  uint32_t total_triangles;    /* of all meshes, committed or not */
  float lo[3], hi[3], largest; /* the largest |coordinate| */
  float stretch;               /* of D of >>exactness: 1, or more for instances, see >>places */
  bool single_tree;            /* there is one tree, at rest, and no instance */
  bool has_top;                /* there are instances, or trees under another */
  bool of_boxes;               /* its triangles stand for boxes, of trees or of instances */
  pktrt_scene **models;        /* each a scene of its own */
  uint32_t model_count, model_capacity;
  pktrt__instance *instances;
  uint32_t instance_count, instance_capacity, free_instances;
  pktrt_scene *boxes; /* as groups, of a mesh for each instance */
  bool rebuild_advised;
  char error[256];
};
/* Tells whether a scene has instances; never, where the build leaves them out. */
PKTRT__INLINE bool pktrt__has_instances(const pktrt_scene *s) { return PKTRT__INSTANCES && s->boxes; }
/* >>memory --------------------------------------------------------------------------------------------------------- */

/* WHY large pages: traversal jumps about in memory, and with pages of 4 KiB each step may also miss the TLB. Large
   pages made builds 1.1 to 1.25 times as fast, and rays up to 1.04 times. */
#if defined(__linux__)
#include <sys/mman.h>
#ifndef MADV_HUGEPAGE /* strict ISO C hides both */
#define MADV_HUGEPAGE 14
int madvise(void *address, size_t size, int advice);
#endif
static const size_t pktrt__mem_large_page = (size_t)2 << 20;
static void pktrt__mem_want_large_pages(void *p, size_t size) { (void)madvise(p, size, MADV_HUGEPAGE); }
#else
static const size_t pktrt__mem_large_page = SIZE_MAX / 2;
static void pktrt__mem_want_large_pages(void *p, size_t size) { (void)p, (void)size; }
#endif

/* Calls malloc, and keeps the distance to the block's true start in front of the aligned part. */
static void *pktrt__mem_malloc(void *user, size_t size, size_t align) {
  (void)user;
  const bool large = size / 2 >= pktrt__mem_large_page;
  if (large) align = pktrt__mem_large_page;
  if (size > SIZE_MAX - align - sizeof(size_t)) return NULL;
  char *raw = PKTRT__CAST(char *, malloc(size + align + sizeof(size_t)));
  if (!raw) return NULL;
  size_t shift = sizeof(size_t) + (align - ((uintptr_t)(raw + sizeof(size_t)) & (align - 1))) % align;
  memcpy(raw + shift - sizeof(size_t), &shift, sizeof(size_t));
  if (large) pktrt__mem_want_large_pages(raw + shift, size);
  return raw + shift;
}
static void pktrt__mem_free(void *user, void *p, size_t size) {
  (void)user, (void)size;
  size_t shift;
  memcpy(&shift, PKTRT__CAST(char *, p) - sizeof(size_t), sizeof(size_t));
  free(PKTRT__CAST(char *, p) - shift);
}

/* Allocates all memory of the library. Returns NULL if count * size overflows, and a valid pointer for zero bytes. */
static void *pktrt__mem_alloc(const pktrt_scene_desc *desc, uint64_t count, size_t size) {
  if (count > (SIZE_MAX - 64) / size) return NULL;
  size_t bytes = (size_t)count * size;
  return desc->allocate(desc->user, bytes ? bytes : 64, 64);
}
static void pktrt__mem_release(const pktrt_scene_desc *desc, void *p, uint64_t count, size_t size) {
  size_t bytes = (size_t)count * size;
  if (p) desc->release(desc->user, p, bytes ? bytes : 64);
}

/* Runs body(arg, i) for i in [0,n), through the hook where there is one. */
static void pktrt__parallel_for(const pktrt_scene_desc *desc, size_t n, void (*body)(void *, size_t), void *arg) {
  if (desc->parallel_for && n > 1) {
    desc->parallel_for(desc->user, n, body, arg);
  } else {
    for (size_t i = 0; i < n; i++) body(arg, i);
  }
}
/* >>basics --------------------------------------------------------------------------------------------------------- */

PKTRT__INLINE uint32_t pktrt__sign_bit(float x) {
  uint32_t u;
  memcpy(&u, &x, sizeof u);
  return u >> 31;
}

#if defined(__GNUC__) || defined(__clang__)
PKTRT__INLINE uint32_t pktrt__lowest_bit(uint64_t x) { return (uint32_t)__builtin_ctzll(x); } /* x != 0 */
PKTRT__INLINE uint32_t pktrt__highest_bit(uint64_t x) { return 63 - (uint32_t)__builtin_clzll(x); }
#else
PKTRT__INLINE uint32_t pktrt__lowest_bit(uint64_t x) {
  uint32_t n = 0;
  for (; !(x & 1); x >>= 1) n++;
  return n;
}
PKTRT__INLINE uint32_t pktrt__highest_bit(uint64_t x) {
  uint32_t n = 0;
  for (; x >>= 1;) n++;
  return n;
}
#endif

/* Counts ones. WHY written out: compilers know this form, and without the instruction theirs is a call. */
PKTRT__INLINE uint32_t pktrt__popcount(uint64_t x) {
  x -= x >> 1 & UINT64_C(0x5555555555555555);
  x = (x & UINT64_C(0x3333333333333333)) + (x >> 2 & UINT64_C(0x3333333333333333));
  return (uint32_t)(((x + (x >> 4)) & UINT64_C(0x0F0F0F0F0F0F0F0F)) * UINT64_C(0x0101010101010101) >> 56);
}

/* Counts ones in 8 bits. WHY: without the instruction, counting 64 is a call; the paper path counts at every test. */
PKTRT__INLINE uint32_t pktrt__popcount8(uint32_t x) {
  x -= x >> 1 & 0x55;
  x = (x & 0x33) + (x >> 2 & 0x33);
  return (x + (x >> 4)) & 0xF;
}

PKTRT__INLINE bool pktrt__has_motion(uint32_t key_count) { return PKTRT__MOTION && key_count > 1; }

/* Converts as vector units do: beyond the range of float the result is an infinity (in C it would be undefined). */
PKTRT__INLINE float pktrt__to_float(double x) {
  const double limit = 3.4028235677973366e38; /* FLT_MAX and half a step: rounds to infinity from here on */
  return x >= limit ? INFINITY : x <= -limit ? -INFINITY : (float)x;
}
PKTRT__INLINE float pktrt__minf(float a, float b) { return a < b ? a : b; }
PKTRT__INLINE float pktrt__maxf(float a, float b) { return a > b ? a : b; }
PKTRT__INLINE double pktrt__min(double a, double b) { return a < b ? a : b; } /* fmin may be a call */
PKTRT__INLINE double pktrt__max(double a, double b) { return a > b ? a : b; }

#ifndef PKTRT_NO_RENDER
/* Mixes all bits of x: the finaliser of splitmix64. */
static uint64_t pktrt__hash(uint64_t x) {
  x += UINT64_C(0x9E3779B97F4A7C15);
  x = (x ^ (x >> 30)) * UINT64_C(0xBF58476D1CE4E5B9);
  x = (x ^ (x >> 27)) * UINT64_C(0x94D049BB133111EB);
  return x ^ (x >> 31);
}

/* Sorts keys in ascending order by heapsort: no allocation, no bad case. */
static void pktrt__sort_keys(uint64_t *key, uint32_t n) {
  for (uint32_t built = n / 2, end = n; end > 1;) {
    uint32_t at = 0;
    if (built) {
      at = --built;
    } else {
      const uint64_t last = key[--end];
      key[end] = key[0], key[0] = last;
    }
    for (uint32_t child; (child = 2 * at + 1) < end; at = child) {
      if (child + 1 < end && key[child] < key[child + 1]) child++;
      if (key[at] >= key[child]) break;
      const uint64_t moved = key[at];
      key[at] = key[child], key[child] = moved;
    }
  }
}
#endif

/* >>build ---------------------------------------------------------------------------------------------------------- */

/* Binary tree first, then wide, then bounds.

   Binary: a range of triangles ("prims": boxes with an id) is split in two where the surface area heuristic says so:
   from bins over the centroids on all three axes while the range is large, from an exact sweep of the sorted centroids
   when it is small; of very large ranges most small triangles are not looked at. A side with n triangles costs
   area * (0.75 ceil(n/8) + 0.25 n/8): whole blocks, with a leaning towards fewer triangles where the number of blocks
   is the same. A range of up to 8 stays a leaf (cost: area) if that is not dearer than a step (0.25 area) plus both
   sides. Moving trees are built on the boxes at the middle of the motion. The partition reads one buffer and writes
   the other; small ranges move back home, so that all leaves lie in the first.

   Depth: let need(n) = ceil(log2(ceil(n/8))), the levels of halving until n triangles fit a block. Every range keeps
   depth + need(n) <= MAX_DEPTH: true at the root (need < 30); where it holds with slack, any split keeps it, since a
   part is smaller than the whole; where it holds with equality the range is halved by index into parts of at most
   ceil(ceil(n/8)/2) blocks, which need one level less. Ranges of up to 8 are split where depth < MAX_DEPTH only. So
   all loops end, and their stacks have known sizes, for any input. Where the heuristic is blind (no extent of
   centroids, no area) the range is halved by index too.

   Range of numbers: coordinates up to 2^100 stay as they are; a tree whose largest is below 1 is scaled up to [1,2);
   areas are taken of extents scaled to [1,2) range by range. So products neither overflow nor vanish where they matter.

   Determinism: a range of n triangles at slot s owns the node slots [s, s + 2n - 1): itself s, its left part of m
   triangles s + 1, its right part s + 2m. Nothing is handed out at run time: parallel tasks write disjoint parts of
   the same arrays, and which tasks there are depends on triangle counts alone. The number of workers changes nothing.

   Wide: a node is given the nodes below its binary root that make the whole tree cheapest (Ylitie, Karras and Laine
   2017), at most eight; blocks are merged where that is cheaper. A block costs 3/4 of its area and 1/10 for each
   triangle, a node 1.25: by expected cost, tasks bottom-up and then what lies above them. Of the high quality, the
   nodes of the binary tree move to better places first, which leaves no room between prims. Subtrees of up to max(4096,
   n/64) triangles are tasks: counted, placed by a prefix sum, written in depth-first order. What lies above, the top,
   comes first, if there are several.

   Bounds: fitted bottom-up from the blocks by the function that refit uses, hence equal to it bit by bit; but leaves of
   a tree with split triangles come with the boxes of their prims.

   Splits (Stich, Friedrich and Dietrich 2009; of the high quality, at rest): where the parts of a large range would
   overlap, and that is cheaper by a twentieth, a plane cuts it instead, and a triangle on both sides becomes two prims,
   each with the box of what lies on its side. A range has room for more prims than it holds, a sixth more at the root,
   which its parts share by what they hold; it owns the node slots of its room. Neither part has more prims than the
   range, so that depth is bounded as above. Blocks have whole triangles, and a ray that meets one of them again finds
   the same t and index, which is no nearer: no answer, and no count of crossings, knows of splits.

   The boxes of a triangle's prims cover it. Let it lie, as far as a prim stands for it, in the prim's box. What of that
   lies at x_a <= c is part of the hull of corners there and points where edges cross the plane: it lies in the box of
   these, and in the prim's. With h = 2^-53, and M the larger of |P_b| and |Q_b|, an edge from P to Q crosses it at

       y = P_b + (Q_b - P_b) ((c - P_a) / (Q_a - P_a))

   in doubles, wrong by h M for the sum and by 2 M (5 h) for five roundings of a term of at most 2 M: below 2^-49 M,
   and none vanishes. Boxes are widened by 2^-23 M + 2^-149; to be floats they are rounded by less than 2^-24 M + 2^-149
   of that. Corners are floats and stay: the union of the boxes is the triangle's. c is a float in coordinates of
   meshes; boxes are scaled by a power of two, not below 1, and nothing is lost on the way there or back. A part whose
   box is empty has no point. A crossing lies on the triangle, hence in a box that covers it: culling asks no more.

   What deforms is not split, nor what is hidden: refits, which know of whole triangles only, would widen its boxes. */

#ifndef PKTRT__SPLIT_PAD                       /* a test makes it negative: hits are lost then, as they should be */
#define PKTRT__SPLIT_PAD 1.1920928955078125e-7 /* 2^-23 */
#endif
#define PKTRT__SPLIT_LEAST_PAD 1.401298464324817e-45 /* 2^-149 */

enum {
  PKTRT__TASK_MIN = 4096, /* triangles */
  PKTRT__TASK_PARTS = 64,
  PKTRT__CHUNK = 16384, /* triangles per task of the first pass */
  PKTRT__MAX_BINS = 64,
  PKTRT__MAX_SWEEP = 64
};

/* Finds the corners of a triangle at a key; of a mesh whose positions changed, the new ones if use_pending. */
PKTRT__INLINE void pktrt__mesh_corners(const pktrt__mesh *m, bool use_pending, uint32_t tri, uint32_t key,
                                       const float *v[3]) {
  const float *p = use_pending && m->dirty && m->pending ? m->pending : m->positions;
  size_t at = (size_t)tri * 3;
  p += (size_t)key * m->vertex_count * 3;
  if (m->indices) {
    const uint32_t *i = m->indices + at;
    v[0] = p + 3 * (size_t)i[0], v[1] = p + 3 * (size_t)i[1], v[2] = p + 3 * (size_t)i[2];
  } else {
    v[0] = p + 3 * at, v[1] = v[0] + 3, v[2] = v[0] + 6;
  }
}
PKTRT__INLINE void pktrt__mesh_triangle(const pktrt__mesh *m, bool use_pending, uint32_t tri, uint32_t key,
                                        float v[3][3]) {
  const float *corner[3];
  pktrt__mesh_corners(m, use_pending, tri, key, corner);
  for (int c = 0; c < 3; c++) v[c][0] = corner[c][0], v[c][1] = corner[c][1], v[c][2] = corner[c][2];
}

/* Finds the mesh of a global triangle index: the last one that starts at or before it, which is not empty. */
PKTRT__NOINLINE uint32_t pktrt__mesh_search(const pktrt__mesh *meshes, uint32_t mesh_count, uint32_t id) {
  uint32_t lo = 0, hi = mesh_count;
  while (hi - lo > 1) {
    const uint32_t mid = lo + (hi - lo) / 2;
    if (meshes[mid].first_id <= id) lo = mid;
    else hi = mid;
  }
  return lo;
}

/* Returns the mesh of a global triangle index; tries `hint`, the mesh of a neighbour, first. */
static uint32_t pktrt__mesh_of_triangle(const pktrt__mesh *meshes, uint32_t mesh_count, uint32_t id, uint32_t hint) {
  if (id - meshes[hint].first_id < meshes[hint].triangle_count) return hint;
  return pktrt__mesh_search(meshes, mesh_count, id);
}

/* A box of the build is lo x,y,z,-, -hi x,y,z,-: two vectors that grow by minima. The free elements of a prim hold the
   halves of the global triangle index as floats in [1,2): vectors compute with them too, and denormals are slow. */
typedef struct pktrt__build_prim {
  float box[8];
} pktrt__build_prim;

PKTRT__INLINE void pktrt__build_set_prim_id(pktrt__build_prim *p, uint32_t id) {
  uint32_t low = 0x3F800000u | (id & 0xFFFFu), high = 0x3F800000u | id >> 16;
  memcpy(&p->box[3], &low, 4), memcpy(&p->box[7], &high, 4);
}
PKTRT__INLINE uint32_t pktrt__build_prim_id(const pktrt__build_prim *p) {
  uint32_t low, high;
  memcpy(&low, &p->box[3], 4), memcpy(&high, &p->box[7], 4);
  return (low & 0xFFFFu) | high << 16;
}

typedef struct pktrt__build_node {
  float size;    /* square root of the area, so that no float overflows */
  uint32_t left; /* prims of the left part, or for how many there is room; 0: a leaf */
  uint32_t plan; /* how the subtree is collapsed: see pktrt__collapse_plan; before that: prims */
} pktrt__build_node;

typedef struct pktrt__build_range {
  float box[8];
  uint32_t slot, first, count, room; /* room: prims that there may be, count or more */
  uint16_t depth, away;              /* away: the prims lie in the second buffer */
} pktrt__build_range;

typedef struct pktrt__builder {
  const pktrt_scene_desc *desc;
  const struct pktrt__fit_table *fit;
  const pktrt__mesh *meshes;
  uint32_t mesh_count, first_mesh, end_mesh, set, key_count, count;
  bool use_pending, hides;
  uint32_t bins, few_bins, few, many; /* `bins` from `many` triangles on, few_bins below `few`, half of bins between */
  uint32_t sweep, sampled;            /* up to `sweep` triangles are swept; from `sampled` on only a part is binned */
  uint32_t limit;                     /* triangles of a task */
  uint32_t passes;                    /* of reinsertion */
  uint32_t room;                      /* prims that there may be: more than count where triangles are split */
  float scale;
  pktrt__build_prim *prims, *away; /* room each */
  pktrt__build_node *nodes;        /* 2 * room - 1 slots */
  pktrt__build_range *chunks;      /* boxes of the chunks in the first pass, later ranges of the top */
} pktrt__builder;

PKTRT__INLINE void pktrt__build_box_clear(float *b) {
  for (int i = 0; i < 8; i++) b[i] = PKTRT__FAR;
}
PKTRT__INLINE void pktrt__build_box_grow(float *b, const float *p) {
  for (int i = 0; i < 8; i++) b[i] = p[i] < b[i] ? p[i] : b[i];
}
/* Returns half the surface area of a box scaled by s. */
PKTRT__INLINE float pktrt__build_box_area(const float *b, float s) {
  float e[4]; /* extents, all signs flipped; the fourth only fills the vector */
  for (int i = 0; i < 4; i++) e[i] = (b[i] + b[i + 4]) * s;
  return e[0] * (e[1] + e[2]) + e[1] * e[2];
}
/* Returns the cost of a side with n triangles, per area: 3/4 a block and 1/32 a triangle. */
PKTRT__INLINE float pktrt__build_side_cost(uint32_t n) {
  return 0.03125f * (float)(24 * ((int64_t)(n + 7) >> 3) + (int64_t)n);
}
/* Returns the power of two that brings x >= 0 to [1,2), as far as there is one. */
static float pktrt__build_unit_scale(float x) {
  uint32_t bits;
  memcpy(&bits, &x, 4);
  bits = (254u - (bits >> 23 > 253u ? 253u : bits >> 23)) << 23;
  memcpy(&x, &bits, 4);
  return x;
}
static uint32_t pktrt__build_halvings(uint32_t n) {
  uint32_t h = 0;
  while (((uint64_t)8 << h) < n) h++;
  return h;
}

/* First pass: boxes of triangles and of chunks */

PKTRT__INLINE void pktrt__build_triangle_box(const float *v[3], float *box) {
  for (int a = 0; a < 3; a++) {
    float x = v[0][a], y = v[1][a], z = v[2][a];
    float l = x < y ? x : y, h = x > y ? x : y;
    box[a] = l < z ? l : z, box[a + 4] = -(h > z ? h : z);
  }
}

PKTRT__INLINE void pktrt__build_prim_box(const pktrt__builder *b, const pktrt__mesh *m, uint32_t tri, float *box) {
  uint32_t key = (b->key_count - 1) / 2, other = b->key_count / 2; /* around the middle of the motion */
  const float *v[3];
  float then[8];
  pktrt__mesh_corners(m, b->use_pending, tri, key, v);
  pktrt__build_triangle_box(v, box);
  if (other == key) return;
  pktrt__mesh_corners(m, b->use_pending, tri, other, v);
  pktrt__build_triangle_box(v, then);
  for (int a = 0; a < 3; a++) box[a] = 0.5f * (box[a] + then[a]), box[a + 4] = 0.5f * (box[a + 4] + then[a + 4]);
}

static void pktrt__build_fill_chunk(void *arg, size_t chunk) {
  pktrt__builder *b = PKTRT__CAST(pktrt__builder *, arg);
  uint32_t begin = (uint32_t)chunk * PKTRT__CHUNK, base = 0;
  uint32_t end = b->count - begin < PKTRT__CHUNK ? b->count : begin + PKTRT__CHUNK;
  float *all = b->chunks[chunk].box;
  pktrt__build_box_clear(all);
  for (uint32_t i = b->first_mesh; i < b->end_mesh && base < end; i++) {
    const pktrt__mesh *m = &b->meshes[i];
    if (m->set != b->set || m->gone) continue;
    uint32_t from = base > begin ? base : begin;
    uint32_t to = m->triangle_count < end - base ? base + m->triangle_count : end;
    for (uint32_t j = from; j < to; j++) {
      float *box = b->prims[j].box;
      pktrt__build_prim_box(b, m, j - base, box);
      pktrt__build_set_prim_id(&b->prims[j], m->first_id + (j - base));
      pktrt__build_box_grow(all, box);
    }
    base += m->triangle_count;
  }
}
static void pktrt__build_scale_chunk(void *arg, size_t chunk) {
  pktrt__builder *b = PKTRT__CAST(pktrt__builder *, arg);
  uint32_t begin = (uint32_t)chunk * PKTRT__CHUNK;
  uint32_t end = b->count - begin < PKTRT__CHUNK ? b->count : begin + PKTRT__CHUNK;
  for (uint32_t j = begin; j < end; j++) {
    float *box = b->prims[j].box;
    for (int a = 0; a < 3; a++) box[a] *= b->scale, box[a + 4] *= b->scale;
  }
}

static void pktrt__build_fill(pktrt__builder *b, pktrt__build_range *root) {
  uint32_t chunks = (b->count + PKTRT__CHUNK - 1) / PKTRT__CHUNK;
  pktrt__parallel_for(b->desc, chunks, pktrt__build_fill_chunk, b);
  memset(root, 0, sizeof *root);
  root->count = b->count, root->room = b->room;
  pktrt__build_box_clear(root->box);
  for (uint32_t i = 0; i < chunks; i++) pktrt__build_box_grow(root->box, b->chunks[i].box);
  root->box[3] = root->box[7] = 0.0f;
  float most = 0.0f;
  for (int i = 0; i < 8; i++) {
    float x = fabsf(root->box[i]);
    most = x > most ? x : most;
  }
  b->scale = most < 1.0f && most > 0.0f ? pktrt__build_unit_scale(most) : 1.0f;
  if (b->scale > 1.0f) {
    for (int i = 0; i < 8; i++) root->box[i] *= b->scale;
    pktrt__parallel_for(b->desc, chunks, pktrt__build_scale_chunk, b);
  }
}

/* Splitting a range */

/* Places the parts of a range, which share what room is left by their counts. */
static void pktrt__build_make_parts(const pktrt__build_range *r, uint32_t left, uint32_t right, bool away,
                                    pktrt__build_range part[2]) {
  const uint64_t all = (uint64_t)left + right, spare = (r->room - all) * left / all;
  const uint32_t room = left + (uint32_t)spare;
  part[0].slot = r->slot + 1, part[1].slot = r->slot + 2 * room;
  part[0].first = r->first, part[1].first = r->first + room;
  part[0].count = left, part[1].count = right;
  part[0].room = room, part[1].room = r->room - room;
  part[0].depth = part[1].depth = (uint16_t)(r->depth + 1);
  part[0].away = part[1].away = away;
}

/* Halves a range by index, in whole blocks. */
static uint32_t pktrt__build_split_half(const pktrt__build_range *r, pktrt__build_prim *p, pktrt__build_range part[2]) {
  uint32_t left = (r->count + 15) / 16 * 8;
  pktrt__build_make_parts(r, left, r->count - left, r->away != 0, part);
  pktrt__build_box_clear(part[0].box), pktrt__build_box_clear(part[1].box);
  for (uint32_t i = 0; i < r->count; i++) pktrt__build_box_grow(part[i >= left].box, p[i].box);
  memmove(p + part[0].room, p + left, part[1].count * sizeof *p);
  return left;
}

/* Returns the unit of a range's areas, by its longest extent. */
static float pktrt__build_unit_of(const pktrt__build_range *r) {
  const double x = (double)r->box[0] + r->box[4], y = (double)r->box[1] + r->box[5], z = (double)r->box[2] + r->box[6];
  return pktrt__build_unit_scale((float)-(x < y ? (x < z ? x : z) : (y < z ? y : z)));
}

typedef struct pktrt__build_bins {
  float box[3][PKTRT__MAX_BINS][8];
  uint32_t count[3][PKTRT__MAX_BINS];
  float low[4], scale[4]; /* bin = (centroid - low) * scale, centroid = lo + hi */
  uint32_t bins, best, axis, total;
} pktrt__build_bins;

/* Finds the extent, from lo to hi, of the centroids of prims. */
static void pktrt__build_find_extent(const pktrt__build_prim *p, uint32_t n, float lo[4], float hi[4]) {
  float least[4], most[4];
  for (int a = 0; a < 4; a++) least[a] = 2.0f * PKTRT__FAR, most[a] = -2.0f * PKTRT__FAR;
  for (uint32_t i = 0; i < n; i++) {
    const float *b = p[i].box;
    for (int a = 0; a < 4; a++) { /* the fourth only fills the vector */
      float c = b[a] - b[a + 4];
      least[a] = c < least[a] ? c : least[a], most[a] = c > most[a] ? c : most[a];
    }
  }
  for (int a = 0; a < 4; a++) lo[a] = least[a], hi[a] = most[a];
}

/* Places the bins on each axis whose extent does not make the scale overflow; returns false if there is none. */
static bool pktrt__build_place_bins(pktrt__build_bins *s, const float lo[4], const float hi[4]) {
  bool any = false;
  for (int a = 0; a < 3; a++) {
    float extent = hi[a] - lo[a];
    s->low[a] = lo[a];
    s->scale[a] = extent > 64.0f * FLT_MIN ? (float)(int32_t)s->bins * 0.9999f / extent : 0.0f;
    any = any || s->scale[a] > 0.0f;
  }
  s->low[3] = s->scale[3] = 0.0f;
  return any;
}

PKTRT__INLINE void pktrt__build_put_in_bins(pktrt__build_bins *s, const float *b, const float low[3],
                                            const float scale[3], uint32_t weight) {
  const size_t x = (size_t)(int32_t)((b[0] - b[4] - low[0]) * scale[0]);
  const size_t y = (size_t)(int32_t)((b[1] - b[5] - low[1]) * scale[1]);
  const size_t z = (size_t)(int32_t)((b[2] - b[6] - low[2]) * scale[2]);
  pktrt__build_box_grow(s->box[0][x], b), s->count[0][x] += weight;
  pktrt__build_box_grow(s->box[1][y], b), s->count[1][y] += weight;
  pktrt__build_box_grow(s->box[2][z], b), s->count[2][z] += weight;
}

/* Puts n prims of a range into bins, or one in four, which stands for the others; but none that is longer along an axis
   than a 32nd of the range is left out: the few large ones decide what a side costs. */
static void pktrt__build_fill_bins(pktrt__build_bins *s, const pktrt__build_prim *p, uint32_t n,
                                   const pktrt__build_range *r, bool all) {
  for (int a = 0; a < 3; a++) {
    for (uint32_t i = 0; i < s->bins; i++) pktrt__build_box_clear(s->box[a][i]), s->count[a][i] = 0;
  }
  const float low[3] = {s->low[0], s->low[1], s->low[2]}, scale[3] = {s->scale[0], s->scale[1], s->scale[2]};
  float large[3];
  for (int a = 0; a < 3; a++) large[a] = (r->box[a] + r->box[a + 4]) * 0.03125f; /* negative, as all extents here */
  uint32_t total = 0;
  for (uint32_t i = 0; i < n; i++) {
    float b[8]; /* a copy, which bins cannot overlap */
    memcpy(b, p[i].box, sizeof b);
    const bool alone = all || (b[0] + b[4] < large[0]) | (b[1] + b[5] < large[1]) | (b[2] + b[6] < large[2]);
    if (i % 4 && !alone) continue;
    const uint32_t weight = alone ? 1 : 4;
    pktrt__build_put_in_bins(s, b, low, scale, weight);
    total += weight;
  }
  s->total = total;
}

/* Finds the cheapest border between bins and returns its cost, FLT_MAX if all prims share one bin on every axis. */
static float pktrt__build_best_bin(pktrt__build_bins *s, float unit) {
  float right[PKTRT__MAX_BINS], best = FLT_MAX;
  for (uint32_t a = 0; a < 3; a++) {
    if (!(s->scale[a] > 0.0f)) continue;
    float box[8];
    uint32_t count = 0;
    pktrt__build_box_clear(box);
    for (uint32_t i = s->bins - 1; i > 0; i--) {
      pktrt__build_box_grow(box, s->box[a][i]);
      count += s->count[a][i];
      right[i] = count ? pktrt__build_box_area(box, unit) * pktrt__build_side_cost(count) : 0.0f;
    }
    pktrt__build_box_clear(box);
    count = 0;
    for (uint32_t i = 0; i + 1 < s->bins; i++) {
      pktrt__build_box_grow(box, s->box[a][i]);
      count += s->count[a][i];
      if (count == 0 || count == s->total) continue;
      float cost = pktrt__build_box_area(box, unit) * pktrt__build_side_cost(count) + right[i + 1];
      if (cost < best) best = cost, s->axis = a, s->best = i;
    }
  }
  return best;
}

/* Tells whether a prim lies beyond the best border. */
PKTRT__INLINE uint32_t pktrt__build_is_right(const pktrt__build_prim *p, uint32_t axis, float low, float scale,
                                             float border) {
  return (p->box[axis] - p->box[axis + 4] - low) * scale >= border;
}

/* Partitions n prims without branches, from l up and from r down. Returns where the next left one would go. */
static uint32_t pktrt__build_partition(const pktrt__build_bins *s, const pktrt__build_prim *from, pktrt__build_prim *to,
                                       uint32_t n, uint32_t l, uint32_t r) {
  const float low = s->low[s->axis], scale = s->scale[s->axis], border = (float)(int32_t)(s->best + 1);
  for (uint32_t i = 0, axis = s->axis; i < n; i++) {
    const uint32_t right = pktrt__build_is_right(&from[i], axis, low, scale, border);
    to[l + (r - l) * right] = from[i];
    l += 1 - right, r -= right;
  }
  return l;
}

/* Counts what a partition would send left. */
static uint32_t pktrt__build_count_left(const pktrt__build_bins *s, const pktrt__build_prim *p, uint32_t n) {
  const float low = s->low[s->axis], scale = s->scale[s->axis], border = (float)(int32_t)(s->best + 1);
  uint32_t right = 0;
  for (uint32_t i = 0; i < n; i++) right += pktrt__build_is_right(&p[i], s->axis, low, scale, border);
  return n - right;
}

static uint32_t pktrt__build_bin_count(const pktrt__builder *b, uint32_t prims) {
  return prims < b->few ? b->few_bins : prims < b->many ? b->bins / 2 : b->bins;
}
static pktrt__build_prim *pktrt__build_from(const pktrt__builder *b, const pktrt__build_range *r) {
  return (r->away ? b->away : b->prims) + r->first;
}
static pktrt__build_prim *pktrt__build_to(const pktrt__builder *b, const pktrt__build_range *r) {
  return (r->away ? b->prims : b->away) + r->first;
}

/* Finds the parts' boxes by the best border between full bins; returns its cost, FLT_MAX if none separates prims. */
static float pktrt__build_choose_bin(pktrt__build_bins *s, const pktrt__build_range *r, pktrt__build_range part[2]) {
  const float cost = pktrt__build_best_bin(s, pktrt__build_unit_of(r));
  pktrt__build_box_clear(part[0].box), pktrt__build_box_clear(part[1].box);
  for (uint32_t i = 0; cost < FLT_MAX && i < s->bins; i++)
    pktrt__build_box_grow(part[i > s->best].box, s->box[s->axis][i]);
  return cost;
}

/* Planes that cut ranges: triangles on both sides are split */

enum {
  PKTRT__SPLIT_BINS = 16,
  PKTRT__SPLIT_LEAST = 256 /* prims of a range: below, it hardly pays */
};

/* Cuts a prim by a plane at x_a = at, in coordinates of meshes, into boxes of both sides; returns which there are. */
static uint32_t pktrt__split_prim(const pktrt__builder *b, const float *prim, uint32_t a, float at, float part[2][8]) {
  pktrt__build_prim whole;
  memcpy(whole.box, prim, sizeof whole.box);
  const uint32_t id = pktrt__build_prim_id(&whole) & ~PKTRT__AGAIN;
  const pktrt__mesh *m = &b->meshes[pktrt__mesh_of_triangle(b->meshes, b->mesh_count, id, b->first_mesh)];
  const float *v[3];
  uint32_t there = 0;
  pktrt__mesh_corners(m, b->use_pending, id - m->first_id, 0, v);
  pktrt__build_box_clear(part[0]), pktrt__build_box_clear(part[1]);
  for (uint32_t c = 0, d = 2; c < 3; d = c++) {
    const float *p = v[c], *q = v[d], from = p[a], to = q[a];
    const bool crossed = (from < at && at < to) || (to < at && at < from);
    const double f = crossed ? ((double)at - (double)from) / ((double)to - (double)from) : 0;
    for (uint32_t i = 0; i < 3; i++) {
      for (uint32_t s = 0; s < 2; s++) {
        if (s ? from < at : from > at) continue;
        part[s][i] = pktrt__minf(part[s][i], p[i]), part[s][i + 4] = pktrt__minf(part[s][i + 4], -p[i]);
      }
      if (!crossed) continue;
      const double y = (double)p[i] + ((double)q[i] - (double)p[i]) * f;
      const double wide = (double)pktrt__maxf(fabsf(p[i]), fabsf(q[i])) * PKTRT__SPLIT_PAD + PKTRT__SPLIT_LEAST_PAD;
      const float lo = (float)(y - wide), hi = (float)(-y - wide);
      for (uint32_t s = 0; s < 2; s++)
        part[s][i] = pktrt__minf(part[s][i], lo), part[s][i + 4] = pktrt__minf(part[s][i + 4], hi);
    }
  }
  part[0][a + 4] = pktrt__maxf(part[0][a + 4], -at), part[1][a] = pktrt__maxf(part[1][a], at);
  for (uint32_t s = 0; s < 2; s++) {
    bool empty = false;
    for (uint32_t i = 0; i < 8; i++) part[s][i] = pktrt__maxf(part[s][i] * b->scale, prim[i]);
    for (uint32_t i = 0; i < 3; i++) empty = empty || part[s][i] > -part[s][i + 4];
    part[s][3] = prim[3], part[s][7] = prim[7];
    if (empty) pktrt__build_box_clear(part[s]);
    else there |= 1u << s;
  }
  return there;
}

/* Finds the cheapest plane across the longest side of a range, in coordinates of meshes, and its cost. */
static float pktrt__split_find_plane(const pktrt__builder *b, const pktrt__build_range *r, uint32_t *axis,
                                     float *best) {
  const pktrt__build_prim *p = pktrt__build_from(b, r);
  const float unit = pktrt__build_unit_of(r);
  float box[PKTRT__SPLIT_BINS][8], at[PKTRT__SPLIT_BINS], right[PKTRT__SPLIT_BINS], all[8], least = FLT_MAX;
  uint32_t enter[PKTRT__SPLIT_BINS], leave[PKTRT__SPLIT_BINS], a = 0, i, l = 0, n = 0;
  for (i = 1; i < 3; i++) a = r->box[i] + r->box[i + 4] < r->box[a] + r->box[a + 4] ? i : a;
  for (i = 0; i < PKTRT__SPLIT_BINS; i++) {
    pktrt__build_box_clear(box[i]), enter[i] = leave[i] = 0;
    at[i] = (r->box[a] - (r->box[a] + r->box[a + 4]) * (float)(int32_t)i / (float)(int)PKTRT__SPLIT_BINS) / b->scale;
  }
  for (uint32_t j = 0; j < r->count; j++) {
    float rest[8], part[2][8];
    memcpy(rest, p[j].box, sizeof rest);
    for (i = 1; i < PKTRT__SPLIT_BINS && at[i] * b->scale <= p[j].box[a];) i++;
    for (enter[i - 1]++; i < PKTRT__SPLIT_BINS && at[i] * b->scale < -p[j].box[a + 4]; i++) {
      pktrt__split_prim(b, rest, a, at[i], part);
      pktrt__build_box_grow(box[i - 1], part[0]);
      memcpy(rest, part[1], 3 * sizeof *rest), memcpy(rest + 4, part[1] + 4, 3 * sizeof *rest);
    }
    pktrt__build_box_grow(box[i - 1], rest), leave[i - 1]++;
  }
  pktrt__build_box_clear(all);
  for (i = PKTRT__SPLIT_BINS - 1; i > 0; i--) {
    pktrt__build_box_grow(all, box[i]), n += leave[i];
    right[i] = n ? pktrt__build_box_area(all, unit) * pktrt__build_side_cost(n) : 0.0f;
  }
  pktrt__build_box_clear(all);
  for (i = 1, n = r->count; i < PKTRT__SPLIT_BINS; i++) {
    pktrt__build_box_grow(all, box[i - 1]), l += enter[i - 1], n -= leave[i - 1];
    if (!l || !n || l + n > r->room) continue;
    const float cost = pktrt__build_box_area(all, unit) * pktrt__build_side_cost(l) + right[i];
    if (cost < least) least = cost, *axis = a, *best = at[i];
  }
  return least;
}

/* Cuts a range by a plane; returns how many prims are on the left, 0 if the range stays as it is. */
static uint32_t pktrt__split_range(const pktrt__builder *b, const pktrt__build_range *r, uint32_t axis, float at,
                                   pktrt__build_range part[2]) {
  const pktrt__build_prim *from = pktrt__build_from(b, r);
  pktrt__build_prim *to = pktrt__build_to(b, r), side[2];
  pktrt__build_range cut[2];
  uint32_t n[2] = {0, 0};
  pktrt__build_box_clear(cut[0].box), pktrt__build_box_clear(cut[1].box);
  for (uint32_t i = 0; i < r->count; i++) {
    float both[2][8];
    uint32_t sides = -from[i].box[axis + 4] <= at * b->scale ? 1 : from[i].box[axis] >= at * b->scale ? 2 : 3;
    const bool across = sides == 3;
    if (across) sides = pktrt__split_prim(b, from[i].box, axis, at, both);
    for (uint32_t s = 0; s < 2; s++) {
      side[s] = from[i];
      if (across && sides) memcpy(side[s].box, both[s], sizeof both[s]);
      if (s ? !(sides & 2) : sides == 2) continue;
      if (s && sides == 3) pktrt__build_set_prim_id(&side[s], pktrt__build_prim_id(&side[s]) | PKTRT__AGAIN);
      pktrt__build_box_grow(cut[s].box, side[s].box);
      to[s ? r->room - ++n[1] : n[0]++] = side[s];
    }
  }
  if (!n[0] || !n[1]) return 0;
  pktrt__build_make_parts(r, n[0], n[1], !r->away, cut);
  memmove(to + cut[0].room, to + r->room - n[1], n[1] * sizeof *to);
  part[0] = cut[0], part[1] = cut[1];
  return n[0];
}

/* Cuts a range by a plane where its best parts, of that cost, overlap and a plane is cheaper; as pktrt__split_range. */
static uint32_t pktrt__split_if_cheaper(const pktrt__builder *b, const pktrt__build_range *r, float cost,
                                        pktrt__build_range part[2]) {
  const float unit = pktrt__build_unit_of(r);
  float both[8], at = 0;
  uint32_t axis = 0;
  for (int i = 0; i < 8; i++) both[i] = pktrt__maxf(part[0].box[i], part[1].box[i]);
  for (int i = 0; i < 3; i++)
    if (both[i] > -both[i + 4] && cost < FLT_MAX) return 0;
  if (cost < FLT_MAX && pktrt__build_box_area(both, unit) < 0.1f * pktrt__build_box_area(r->box, unit)) return 0;
  if (!(pktrt__split_find_plane(b, r, &axis, &at) < 0.95f * cost)) return 0;
  return pktrt__split_range(b, r, axis, at, part);
}

/* Splits a large range by bins; returns how many prims are on the left, 0 if no border separates any. */
static uint32_t pktrt__build_split_binned(pktrt__builder *b, const pktrt__build_range *r, pktrt__build_range part[2]) {
  const pktrt__build_prim *from = pktrt__build_from(b, r);
  float lo[4], hi[4];
  pktrt__build_bins s;
  s.bins = pktrt__build_bin_count(b, r->count);
  pktrt__build_find_extent(from, r->count, lo, hi);
  if (!pktrt__build_place_bins(&s, lo, hi)) return 0;
  pktrt__build_fill_bins(&s, from, r->count, r, r->count < b->sampled);
  const float cost = pktrt__build_choose_bin(&s, r, part);
  uint32_t left = 0, last = r->count - 1;
  if (r->room > r->count && r->count >= PKTRT__SPLIT_LEAST) left = pktrt__split_if_cheaper(b, r, cost, part);
  if (left || !(cost < FLT_MAX)) return left;
  if (r->room > r->count) {
    left = pktrt__build_count_left(&s, from, r->count);
    pktrt__build_make_parts(r, left, r->count - left, !r->away, part);
    last += part[0].room - left;
  }
  left = pktrt__build_partition(&s, from, pktrt__build_to(b, r), r->count, 0, last);
  pktrt__build_make_parts(r, left, r->count - left, !r->away, part);
  return left;
}

/* Makes the lesser of two keys the first, on each axis. */
PKTRT__INLINE void pktrt__build_exchange(float *first, float *second) {
  float least[4], most[4];
  for (int a = 0; a < 4; a++) { /* the fourth only fills the vector */
    const float x = first[a], y = second[a];
    least[a] = x < y ? x : y, most[a] = x > y ? x : y;
  }
  memcpy(first, least, sizeof least), memcpy(second, most, sizeof most);
}

/* Sorts the prims of a range by centroid along all axes at once, by Batcher's network (1968): the same exchanges
   whatever the keys are. These are distances from the range's low side, with the prims' numbers for last bits. */
static void pktrt__build_sort(const pktrt__build_prim *p, const pktrt__build_range *r,
                              uint8_t order[3][PKTRT__MAX_SWEEP]) {
  float key[PKTRT__MAX_SWEEP][4];
  const uint32_t n = r->count;
  uint32_t bits;
  for (uint32_t i = 0; i < n; i++) {
    for (int a = 0; a < 4; a++) key[i][a] = p[i].box[a] - p[i].box[a + 4] - 2 * r->box[a];
    for (int a = 0; a < 3; a++) {
      memcpy(&bits, &key[i][a], 4);
      bits = (bits & ~(PKTRT__MAX_SWEEP - 1u)) | i;
      memcpy(&key[i][a], &bits, 4);
    }
  }
  for (uint32_t whole = 1; whole < n; whole *= 2) /* merges sorted parts of that many keys */
    for (uint32_t apart = whole; apart; apart /= 2)
      for (uint32_t from = apart % whole; from + apart < n; from += 2 * apart) {
        const uint32_t end = from + 2 * apart < n ? from + apart : n - apart;
        for (uint32_t i = from; i < end; i++)
          if (!((i ^ (i + apart)) & 2 * whole)) pktrt__build_exchange(key[i], key[i + apart]);
      }
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      memcpy(&bits, &key[i][a], 4);
      order[a][i] = (uint8_t)(bits & (PKTRT__MAX_SWEEP - 1u));
    }
}

/* Splits a small range at the cheapest cut of its sorted prims on any axis, and moves the prims; returns how many are
   on the left, 0 for a range that had better stay a leaf. */
static uint32_t pktrt__build_split_sweep(pktrt__build_prim *p, const pktrt__build_range *r,
                                         pktrt__build_range part[2]) {
  const float unit = pktrt__build_unit_of(r), area = pktrt__build_box_area(r->box, unit);
  uint8_t order[3][PKTRT__MAX_SWEEP];
  float right[PKTRT__MAX_SWEEP], cost_of[PKTRT__MAX_SWEEP], best = FLT_MAX, box[8];
  uint32_t n = r->count, axis = 0, left = 0;
  for (uint32_t i = 0; i < n; i++) cost_of[i] = pktrt__build_side_cost(i);
  pktrt__build_sort(p, r, order);
  for (uint32_t a = 0; a < 3; a++) {
    pktrt__build_box_clear(box);
    for (uint32_t i = n - 1; i > 0; i--) {
      pktrt__build_box_grow(box, p[order[a][i]].box);
      right[i] = pktrt__build_box_area(box, unit) * cost_of[n - i];
    }
    pktrt__build_box_clear(box);
    for (uint32_t i = 1; i < n; i++) {
      pktrt__build_box_grow(box, p[order[a][i - 1]].box);
      float cost = pktrt__build_box_area(box, unit) * cost_of[i] + right[i];
      if (cost < best) best = cost, axis = a, left = i;
    }
  }
  if (n <= 8 && area <= 0.25f * area + best) return 0;
  pktrt__build_prim sorted[PKTRT__MAX_SWEEP];
  pktrt__build_box_clear(part[0].box), pktrt__build_box_clear(part[1].box);
  for (uint32_t i = 0; i < n; i++) {
    sorted[i] = p[order[axis][i]];
    pktrt__build_box_grow(part[i >= left].box, sorted[i].box);
  }
  pktrt__build_make_parts(r, left, n - left, false, part);
  memcpy(p, sorted, left * sizeof *p), memcpy(p + part[0].room, sorted + left, (n - left) * sizeof *p);
  return left;
}

/* Tells whether a range can be split by where its prims are: its boxes have an area, and levels are left for halving. */
static bool pktrt__build_is_seen(const pktrt__build_range *r) {
  const uint32_t spare = PKTRT__MAX_DEPTH - r->depth - pktrt__build_halvings(r->count);
  return r->count > 1 && spare > 0 && pktrt__build_box_area(r->box, pktrt__build_unit_of(r)) > 0.0f;
}

/* Writes a range's binary node, after halving it if it is too large for a leaf and not split yet (left: 0); returns
   false if it is a leaf. */
static bool pktrt__build_write_node(const pktrt__builder *b, const pktrt__build_range *r, uint32_t left,
                                    pktrt__build_range part[2]) {
  const double x = (double)r->box[0] + r->box[4], y = (double)r->box[1] + r->box[5], z = (double)r->box[2] + r->box[6];
  if (!left && r->count > 8) left = pktrt__build_split_half(r, pktrt__build_from(b, r), part);
  pktrt__build_node *node = &b->nodes[r->slot];
  node->size = (float)sqrt(x * y + y * z + z * x), node->left = left ? part[0].room : 0, node->plan = r->count;
  return left != 0;
}

/* Splits a range and writes its binary node; returns false if it is a leaf. */
static bool pktrt__build_split(pktrt__builder *b, pktrt__build_range *r, pktrt__build_range part[2]) {
  const bool few = r->count <= b->sweep;
  uint32_t left = 0;
  if (r->away && few) {
    memcpy(b->prims + r->first, b->away + r->first, r->count * sizeof *b->prims);
    r->away = 0;
  }
  if (pktrt__build_is_seen(r))
    left = few ? pktrt__build_split_sweep(b->prims + r->first, r, part) : pktrt__build_split_binned(b, r, part);
  return pktrt__build_write_node(b, r, left, part);
}

/* Reinsertion (Bittner, Hapala and Havran 2013; the search as in Meister and Bittner 2018): each node of the binary
   tree in turn is taken out, with all below it, and put back where the areas of all boxes sum up to the least. This is
   done one node after the other, so that the tree depends on the order alone. */

typedef struct pktrt__reinsert_node { /* a node of the binary tree while nodes move; node 0 stays the root */
  float box[8];
  uint32_t parent, child[2]; /* of a leaf: PKTRT_NONE, its first prim */
  uint32_t count, height;
} pktrt__reinsert_node;

enum { PKTRT__SEARCH = 512 }; /* the most nodes that a search visits: among heaps of boxes nothing is pruned */

PKTRT__NOINLINE void pktrt__reinsert_update_node(pktrt__reinsert_node *nodes, uint32_t at) {
  pktrt__reinsert_node *t = &nodes[at];
  const pktrt__reinsert_node *l = &nodes[t->child[0]], *r = &nodes[t->child[1]];
  for (int i = 0; i < 8; i++) t->box[i] = l->box[i] < r->box[i] ? l->box[i] : r->box[i];
  t->count = l->count + r->count, t->height = 1 + (l->height > r->height ? l->height : r->height);
}

PKTRT__NOINLINE uint32_t pktrt__reinsert_count_nodes(const pktrt__build_node *nodes, uint32_t slot) {
  const uint32_t left = nodes[slot].left;
  return left ? 1 + pktrt__reinsert_count_nodes(nodes, slot + 1) + pktrt__reinsert_count_nodes(nodes, slot + 2 * left)
              : 1;
}

/* Makes the nodes of a range's subtree; returns the number of the next free node. */
static uint32_t pktrt__reinsert_make_nodes(const pktrt__builder *b, pktrt__reinsert_node *nodes, uint32_t at,
                                           uint32_t slot, uint32_t first) {
  pktrt__reinsert_node *t = &nodes[at];
  const uint32_t left = b->nodes[slot].left, count = b->nodes[slot].plan, l = at + 1;
  if (left) {
    const uint32_t r = pktrt__reinsert_make_nodes(b, nodes, l, slot + 1, first);
    const uint32_t next = pktrt__reinsert_make_nodes(b, nodes, r, slot + 2 * left, first + left);
    t->child[0] = l, t->child[1] = r, nodes[l].parent = nodes[r].parent = at;
    pktrt__reinsert_update_node(nodes, at);
    return next;
  }
  t->child[0] = PKTRT_NONE, t->child[1] = first, t->count = count, t->height = 0;
  pktrt__build_box_clear(t->box);
  for (uint32_t i = 0; i < count; i++) pktrt__build_box_grow(t->box, b->prims[first + i].box);
  return l;
}

/* Finds the best new sibling for node x, by the sum of all boxes' areas; returns PKTRT_NONE if x had better stay. */
PKTRT__NOINLINE uint32_t pktrt__reinsert_find_place(const pktrt__reinsert_node *nodes, uint32_t x, float unit) {
  struct {
    uint32_t node;
    float gain;
  } stack[PKTRT__MAX_DEPTH + 2];
  const float own = pktrt__build_box_area(nodes[x].box, unit);
  uint32_t place = PKTRT_NONE, from = x, at = nodes[x].parent, steps = 0;
  float rest[8], joint[8], best = 0.0f, gain = pktrt__build_box_area(nodes[at].box, unit);
  pktrt__build_box_clear(rest);
  for (;; from = at, at = nodes[at].parent) {
    const uint32_t beside = nodes[at].child[nodes[at].child[0] == from];
    uint32_t top = 0;
    stack[top].node = beside, stack[top++].gain = gain;
    while (top && steps++ < PKTRT__SEARCH) {
      const pktrt__reinsert_node *t = &nodes[stack[--top].node];
      for (int i = 0; i < 8; i++) joint[i] = t->box[i] < nodes[x].box[i] ? t->box[i] : nodes[x].box[i];
      const float here = stack[top].gain - pktrt__build_box_area(joint, unit);
      const float below = here + pktrt__build_box_area(t->box, unit);
      if (here > best) best = here, place = stack[top].node;
      if (!t->height || !(below - own > best)) continue;
      stack[top].node = t->child[0], stack[top++].gain = below;
      stack[top].node = t->child[1], stack[top++].gain = below;
    }
    const float area = pktrt__build_box_area(nodes[at].box, unit);
    pktrt__build_box_grow(rest, nodes[beside].box); /* what is left of this node without x */
    if (from != x) gain += area - pktrt__build_box_area(rest, unit);
    if (from != x && at && gain - area > best) best = gain - area, place = at;
    if (!at) return place;
  }
}

/* Takes a node and its parent out of the tree and puts both beside another node, unless the tree became too deep. */
static void pktrt__reinsert_move_node(pktrt__reinsert_node *nodes, uint32_t x, uint32_t place) {
  const uint32_t p = nodes[x].parent, above = nodes[p].parent, other = nodes[p].child[nodes[p].child[0] == x];
  uint32_t depth = 1 + (nodes[x].height > nodes[place].height ? nodes[x].height : nodes[place].height);
  for (uint32_t i = place; i; i = nodes[i].parent) depth++;
  if (depth > PKTRT__MAX_DEPTH) return;
  nodes[above].child[nodes[above].child[1] == p] = other, nodes[other].parent = above;
  const uint32_t q = nodes[place].parent;
  nodes[q].child[nodes[q].child[1] == place] = p, nodes[p].parent = q;
  nodes[p].child[0] = place, nodes[p].child[1] = x, nodes[place].parent = p;
  for (uint32_t i = above; i; i = nodes[i].parent) pktrt__reinsert_update_node(nodes, i);
  for (uint32_t i = p; i; i = nodes[i].parent) pktrt__reinsert_update_node(nodes, i);
  pktrt__reinsert_update_node(nodes, 0);
}

/* Writes the subtree back as build nodes, with the prims in its order. */
static void pktrt__reinsert_lay_out(const pktrt__builder *b, const pktrt__reinsert_node *nodes, uint32_t at,
                                    uint32_t slot, uint32_t first) {
  const pktrt__reinsert_node *t = &nodes[at];
  const double x = (double)t->box[0] + t->box[4], y = (double)t->box[1] + t->box[5], z = (double)t->box[2] + t->box[6];
  const uint32_t left = t->height ? nodes[t->child[0]].count : 0;
  b->nodes[slot].size = (float)sqrt(x * y + y * z + z * x), b->nodes[slot].left = left;
  if (!left) {
    memcpy(b->away + first, b->prims + t->child[1], t->count * sizeof *b->prims);
    return;
  }
  pktrt__reinsert_lay_out(b, nodes, t->child[0], slot + 1, first);
  pktrt__reinsert_lay_out(b, nodes, t->child[1], slot + 2 * left, first + left);
}

/* Reinserts all nodes of the binary tree, and leaves no room between prims; returns false when out of memory. */
static bool pktrt__reinsert_nodes(pktrt__builder *b) {
  const uint32_t n = pktrt__reinsert_count_nodes(b->nodes, 0);
  pktrt__reinsert_node *nodes = PKTRT__CAST(pktrt__reinsert_node *, pktrt__mem_alloc(b->desc, n, sizeof *nodes));
  if (!nodes) return false;
  pktrt__reinsert_make_nodes(b, nodes, 0, 0, 0);
  nodes[0].parent = 0, b->count = nodes[0].count;
  float most = 0.0f;
  for (int a = 0; a < 3; a++) most = pktrt__maxf(most, -(nodes[0].box[a] + nodes[0].box[a + 4]));
  const float unit = pktrt__build_unit_scale(most);
  for (uint32_t pass = 0; pass < b->passes; pass++) {
    for (uint32_t x = 1; x < n; x++) {
      const uint32_t place = nodes[x].parent ? pktrt__reinsert_find_place(nodes, x, unit) : PKTRT_NONE;
      if (place != PKTRT_NONE) pktrt__reinsert_move_node(nodes, x, place);
    }
  }
  pktrt__reinsert_lay_out(b, nodes, 0, 0, 0);
  pktrt__build_prim *prims = b->prims;
  b->prims = b->away, b->away = prims;
  pktrt__mem_release(b->desc, nodes, n, sizeof *nodes);
  return true;
}

/* Plans the collapse: which nodes of the binary tree become children of wide nodes, and which subtrees become leaves.
   cost[j] receives the least expected cost, times the area, of a subtree that is represented by up to j nodes or
   blocks, for j from 1 to 7: for one it is the cost of a block, or of a wide node, which has up to eight children. The
   plan of a node has, for j from 2 to 8, three bits from bit 3 (j - 2) on: how many of the j go to the left part, or 0
   if the subtree stays whole. Subtrees that had better be blocks become leaves. */
static void pktrt__collapse_plan(pktrt__build_node *nodes, uint32_t slot, uint32_t count, double cost[8],
                                 const pktrt__build_range *done, uint32_t done_count) {
  pktrt__build_node *node = &nodes[slot];
  const double area = (double)node->size * node->size, leaf = area * (0.75 * ((count + 7) >> 3) + 0.1 * count);
  for (uint32_t i = 0; i < done_count; i++) {
    if (done[i].slot != slot) continue;
    for (uint32_t j = 1; j < 8; j++) cost[j] = area * (double)done[i].box[j];
    return;
  }
  node->plan = 0;
  for (uint32_t j = 1; j < 8 && !node->left; j++) cost[j] = leaf;
  if (!node->left) return;
  double l[8], r[8], best[8 + 1];
  pktrt__collapse_plan(nodes, slot + 1, node->left, l, done, done_count);
  pktrt__collapse_plan(nodes, slot + 2 * node->left, count - node->left, r, done, done_count);
  for (uint32_t j = 8; j > 1; j--) {
    uint32_t share = 1;
    best[j] = l[1] + r[j - 1];
    for (uint32_t k = 2; k < j; k++)
      if (l[k] + r[j - k] < best[j]) best[j] = l[k] + r[j - k], share = k;
    if (j == 8) cost[1] = 1.25 * area + best[j];
    if (j == 8 && count <= 8 && leaf <= cost[1]) cost[1] = leaf, node->left = 0;
    if (j < 8) cost[j] = node->left ? pktrt__min(cost[1], best[j]) : leaf;
    if (j == 8 || best[j] < cost[1]) node->plan |= share << 3 * (j - 2);
  }
}

/* Plans the collapse of a range's whole subtree, and keeps its costs in place of the range's box. */
static void pktrt__collapse_plan_range(const pktrt__builder *b, pktrt__build_range *r) {
  double cost[8];
  const double size = b->nodes[r->slot].size, area = size * size;
  pktrt__collapse_plan(b->nodes, r->slot, r->count, cost, NULL, 0);
  for (uint32_t j = 1; j < 8; j++) r->box[j] = area > 0.0 ? (float)(cost[j] / area) : 0.0f;
}

/* Builds the whole subtree of a range. The stack holds at most one right part per level. */
static void pktrt__build_range_tree(void *arg, size_t index) {
  pktrt__builder *b = PKTRT__CAST(pktrt__builder *, arg);
  pktrt__build_range stack[PKTRT__MAX_DEPTH + 1], part[2];
  uint32_t top = 0;
  stack[top++] = b->chunks[index];
  while (top) {
    pktrt__build_range r = stack[--top];
    while (pktrt__build_split(b, &r, part)) {
      stack[top++] = part[1];
      r = part[0];
    }
  }
  if (!b->passes) pktrt__collapse_plan_range(b, &b->chunks[index]);
}

/* One round splits all ranges above the tasks by one level: range i into parts 2i and 2i + 1. Where ranges are few, each
   is cut into pieces, which many workers treat step by step: centroids' extent, bins, then the prims' new places. What
   pieces find adds up to what one worker would find, whatever their number: smallest and largest values, and counts. */
enum { PKTRT__PIECE = 4096, PKTRT__FEW_RANGES = 16, PKTRT__MOST_PIECES = 1024 };

typedef struct pktrt__build_piece {
  pktrt__build_bins bins; /* those of a range's first piece become all its pieces' */
  float lo[4], hi[4];
  uint32_t head;                /* the first piece of its range, whose `binned` tells whether that is split so */
  uint32_t range, first, count; /* first: in the range, a multiple of four */
  uint32_t left, l, r;          /* prims that go left, and where they go */
  bool binned;
} pktrt__build_piece;

typedef struct pktrt__build_round {
  pktrt__builder *b;
  pktrt__build_range *ranges, *parts;
  pktrt__build_piece *pieces; /* NULL: one worker a range */
  uint32_t step;
} pktrt__build_round;

static void pktrt__build_split_job(void *arg, size_t i) {
  pktrt__build_round *round = PKTRT__CAST(pktrt__build_round *, arg);
  pktrt__build_split(round->b, &round->ranges[i], &round->parts[2 * i]); /* ranges of more than 8 always split */
}

static void pktrt__build_piece_job(void *arg, size_t i) {
  const pktrt__build_round *round = PKTRT__CAST(const pktrt__build_round *, arg);
  pktrt__build_piece *piece = &round->pieces[i];
  const pktrt__build_piece *head = &round->pieces[piece->head];
  const pktrt__build_range *r = &round->ranges[piece->range];
  const pktrt__build_prim *from = pktrt__build_from(round->b, r) + piece->first;
  if (!head->binned) return;
  switch (round->step) {
  case 0:
    piece->bins.bins = pktrt__build_bin_count(round->b, r->count);
    pktrt__build_find_extent(from, piece->count, piece->lo, piece->hi);
    break;
  case 1:
    for (int a = 0; piece != head && a < 4; a++)
      piece->bins.low[a] = head->bins.low[a], piece->bins.scale[a] = head->bins.scale[a];
    pktrt__build_fill_bins(&piece->bins, from, piece->count, r, r->count < round->b->sampled);
    break;
  case 2: piece->left = pktrt__build_count_left(&head->bins, from, piece->count); break;
  default:
    pktrt__build_partition(&head->bins, from, pktrt__build_to(round->b, r), piece->count, piece->l, piece->r);
    break;
  }
}

/* Cuts the ranges of a round into pieces; returns how many. */
static uint32_t pktrt__build_cut_pieces(pktrt__build_round *round, uint32_t ranges) {
  const uint32_t most = PKTRT__MOST_PIECES / PKTRT__FEW_RANGES;
  uint32_t n = 0;
  for (uint32_t i = 0; i < ranges; i++) {
    const uint32_t all = round->ranges[i].count, head = n;
    const uint32_t each = all / PKTRT__PIECE < most ? (uint32_t)PKTRT__PIECE : (all / most / 4 + 1) * 4;
    for (uint32_t first = 0; first < all; first += each, n++) {
      pktrt__build_piece *piece = &round->pieces[n];
      piece->head = head, piece->range = i, piece->binned = true, piece->first = first;
      piece->count = all - first < each ? all - first : each;
    }
  }
  return n;
}

/* Adds up in a range's first piece what its pieces, up to end, have found in a step. */
static void pktrt__build_join_pieces(pktrt__build_round *round, pktrt__build_piece *head,
                                     const pktrt__build_piece *end) {
  const pktrt__build_range *r = &round->ranges[head->range];
  pktrt__build_range *part = &round->parts[2 * head->range];
  uint32_t left = 0;
  for (pktrt__build_piece *p = head; p < end; p++) {
    if (round->step == 2) p->l = left, p->r = r->count - 1 - (p->first - left), left += p->left;
    if (round->step == 1 && p != head) {
      for (int a = 0; a < 3; a++) {
        for (uint32_t i = 0; i < head->bins.bins; i++) {
          pktrt__build_box_grow(head->bins.box[a][i], p->bins.box[a][i]);
          head->bins.count[a][i] += p->bins.count[a][i];
        }
      }
      head->bins.total += p->bins.total;
    }
    for (int a = 0; a < 4 && round->step == 0; a++)
      head->lo[a] = pktrt__minf(head->lo[a], p->lo[a]), head->hi[a] = pktrt__maxf(head->hi[a], p->hi[a]);
  }
  if (round->step == 0)
    head->binned = pktrt__build_is_seen(r) && pktrt__build_place_bins(&head->bins, head->lo, head->hi);
  if (round->step == 1) head->binned = pktrt__build_choose_bin(&head->bins, r, part) < FLT_MAX;
  if (round->step == 2) pktrt__build_make_parts(r, left, r->count - left, !r->away, part);
  if (round->step == 2 || !head->binned) pktrt__build_write_node(round->b, r, left, part);
}

/* Splits the few ranges of a round, piece by piece. */
static void pktrt__build_split_pieces(pktrt__build_round *round, uint32_t ranges) {
  const uint32_t n = pktrt__build_cut_pieces(round, ranges);
  for (round->step = 0; round->step < 4; round->step++) {
    pktrt__parallel_for(round->b->desc, n, pktrt__build_piece_job, round);
    for (uint32_t head = 0, end; head < n; head = end) {
      for (end = head + 1; end < n && round->pieces[end].head == head;) end++;
      if (round->pieces[head].binned && round->step < 3)
        pktrt__build_join_pieces(round, &round->pieces[head], &round->pieces[end]);
    }
  }
}

/* Bounds the number of ranges in a round: those of more than `limit` prims are disjoint, so there are at most room
   / limit of them in each of MAX_DEPTH rounds; each split adds at most one range to the list of those done. */
static uint64_t pktrt__build_most_wide(const pktrt__builder *b) { return b->room / b->limit + 1; }
static uint64_t pktrt__build_most_done(const pktrt__builder *b) {
  return pktrt__build_most_wide(b) * PKTRT__MAX_DEPTH + 1;
}

/* Bounds the pieces of a round; 0 where nobody would share them, or planes may cut ranges. */
static uint64_t pktrt__build_most_pieces(const pktrt__builder *b) {
  const uint32_t n = b->count / PKTRT__PIECE + PKTRT__FEW_RANGES;
  if (!b->desc->parallel_for || b->count <= b->limit || b->room > b->count) return 0;
  return n < PKTRT__MOST_PIECES ? n : (uint32_t)PKTRT__MOST_PIECES;
}

static bool pktrt__build_binary_tree(pktrt__builder *b) {
  pktrt__build_range root;
  pktrt__build_fill(b, &root);
  pktrt__build_range *done = b->chunks; /* the chunks' boxes are no longer needed */
  pktrt__build_round round;
  round.b = b, round.ranges = done + pktrt__build_most_done(b), round.parts = round.ranges + pktrt__build_most_wide(b);
  uint32_t done_count = 0, wide_count = 0;
  const uint64_t pieces = pktrt__build_most_pieces(b);
  round.pieces =
      pieces ? PKTRT__CAST(pktrt__build_piece *, pktrt__mem_alloc(b->desc, pieces, sizeof *round.pieces)) : NULL;
  if (pieces && !round.pieces) return false;
  if (root.count <= b->limit) done[done_count++] = root;
  else round.ranges[wide_count++] = root;
  while (wide_count) {
    if (round.pieces && wide_count <= PKTRT__FEW_RANGES) pktrt__build_split_pieces(&round, wide_count);
    else pktrt__parallel_for(b->desc, wide_count, pktrt__build_split_job, &round);
    uint32_t parts = 2 * wide_count;
    wide_count = 0;
    for (uint32_t i = 0; i < parts; i++) {
      if (round.parts[i].count <= b->limit) done[done_count++] = round.parts[i];
      else round.ranges[wide_count++] = round.parts[i];
    }
  }
  pktrt__mem_release(b->desc, round.pieces, pieces, sizeof *round.pieces);
  pktrt__parallel_for(b->desc, done_count, pktrt__build_range_tree, b);
  double cost[8];
  if (b->passes && !pktrt__reinsert_nodes(b)) return false;
  if (b->passes || done_count > 1) pktrt__collapse_plan(b->nodes, 0, b->count, cost, done, b->passes ? 0 : done_count);
  return true;
}

/* Blocks */

/* The mesh that is being read: blocks take most of their triangles from one. */
typedef struct pktrt__mesh_reader {
  const pktrt__mesh *meshes;
  const float *positions;
  const uint32_t *indices;
  size_t step; /* floats to the next key */
  uint32_t mesh_count, first, count;
  bool use_pending, hides; /* hides: some mesh of the set is hidden */
} pktrt__mesh_reader;

static pktrt__mesh_reader pktrt__mesh_reader_make(const pktrt__mesh *meshes, uint32_t mesh_count, bool use_pending,
                                                  bool hides) {
  pktrt__mesh_reader r;
  memset(&r, 0, sizeof r);
  r.meshes = meshes, r.mesh_count = mesh_count, r.use_pending = use_pending, r.hides = hides;
  return r;
}
static pktrt__mesh_reader pktrt__mesh_reader_seek(pktrt__mesh_reader r, uint32_t triangle) {
  const pktrt__mesh *m = &r.meshes[pktrt__mesh_of_triangle(r.meshes, r.mesh_count, triangle, 0)];
  r.positions = r.use_pending && m->dirty && m->pending ? m->pending : m->positions;
  r.indices = m->indices, r.step = (size_t)m->vertex_count * 3;
  r.first = m->first_id, r.count = m->triangle_count;
  return r;
}

/* The number of blocks ahead that the corners of triangles are found and prefetched, and twice as many ahead their
   indices, as long as the mesh stays the same. WHY: the triangles of a block come from all over the mesh. */
enum { PKTRT__AHEAD = 8 };
typedef struct pktrt__block_source {
  const float *corner[8][3]; /* at key 0; free lanes repeat lane 0 */
  size_t step[8];            /* floats to the next key */
} pktrt__block_source;

/* Shrinks the triangles of hidden meshes to a corner of one that is seen, so that they have no area; if there is none, to where
   no triangle can be. */
PKTRT__COLD void pktrt__block_hide(const uint32_t *tri, const pktrt__mesh_reader *r, pktrt__block_source *s) {
  static const float nowhere[3] = {2 * PKTRT__FAR, 2 * PKTRT__FAR, 2 * PKTRT__FAR};
  uint32_t hide = 0;
  for (uint32_t l = 0, mesh = 0; l < 8; l++) {
    if (tri[l] != PKTRT_NONE) mesh = pktrt__mesh_of_triangle(r->meshes, r->mesh_count, tri[l] & ~PKTRT__AGAIN, mesh);
    hide |= (tri[l] != PKTRT_NONE ? (uint32_t)r->meshes[mesh].hide : hide & 1) << l;
  }
  const uint32_t from = pktrt__lowest_bit(~hide);
  for (uint32_t l = 0; l < 8; l++) {
    if (!(hide >> l & 1)) continue;
    for (int c = 0; c < 3; c++) s->corner[l][c] = from < 8 ? s->corner[from][0] : nowhere;
    s->step[l] = from < 8 ? s->step[from] : 0;
  }
}

static void pktrt__block_find_source(const pktrt__bvh *bvh, uint32_t block, uint32_t end, pktrt__mesh_reader *reader,
                                     pktrt__block_source *s) {
  const uint32_t *tri = bvh->block_triangles + (size_t)block * 8;
  const uint32_t *later = end - block > PKTRT__AHEAD ? tri + (uint32_t)PKTRT__AHEAD * 8 : tri;
  pktrt__mesh_reader r = *reader;
  for (uint32_t i = 0; i < PKTRT__BLOCK_BYTES; i += 64)
    PKTRT__PREFETCH(bvh->blocks + (size_t)block * bvh->block_bytes + i);
  for (uint32_t l = 0; l < 8; l++) {
    if (tri[l] == PKTRT_NONE) {
      memcpy(s->corner[l], s->corner[0], sizeof s->corner[0]);
      s->step[l] = s->step[0];
      continue;
    }
    const uint32_t triangle = tri[l] & ~PKTRT__AGAIN;
    if (triangle - r.first >= r.count) r = pktrt__mesh_reader_seek(r, triangle);
    const size_t at = (size_t)(triangle - r.first) * 3;
    size_t i = at, j = at + 1, k = at + 2;
    if (r.indices) {
      if (later[l] - r.first < r.count) PKTRT__PREFETCH(r.indices + (size_t)(later[l] - r.first) * 3);
      i = r.indices[at], j = r.indices[at + 1], k = r.indices[at + 2];
    }
    PKTRT__PREFETCH(s->corner[l][0] = r.positions + 3 * i);
    PKTRT__PREFETCH(s->corner[l][1] = r.positions + 3 * j);
    PKTRT__PREFETCH(s->corner[l][2] = r.positions + 3 * k);
    s->step[l] = r.step;
  }
  *reader = r;
  if (PKTRT__UNLIKELY(r.hides)) pktrt__block_hide(tri, reader, s);
}

#ifndef PKTRT_NO_RENDER
struct pktrt__light_target;
struct pktrt__surfaces;
struct pktrt__light_samples;
#endif
/* The kernels of builds and refits, >>fit, and of samples of lights, >>shade. The first tells which lanes of a block's
   vertices at a key have area. The second fits bounds and child orders of a run of nodes whose blocks, and nodes below
   in other runs, are done; it returns the sum of the children's areas over all keys. The third samples points of a
   quad, a sphere or an environment without a table, and their factors, by u and v for all surfaces; factors of those
   that take a closer look are -1, and it tells whether there are any. */
typedef struct pktrt__fit_table {
  uint32_t (*lanes_with_area)(const float *vertices);
  double (*nodes)(const pktrt__bvh *, uint32_t first, uint32_t count);
#ifndef PKTRT_NO_RENDER
  bool (*sample_light)(const pktrt_light *, const struct pktrt__light_target *, const float *u, const float *v,
                       const struct pktrt__surfaces *, struct pktrt__light_samples *);
#endif
} pktrt__fit_table;
static const pktrt__fit_table *pktrt__fit_table_of(pktrt_isa);

/* Counts the triangles of a block that have no area, each in one of its blocks. */
static uint32_t pktrt__block_count_degenerate(const uint32_t *tri, const uint32_t *id) {
  uint32_t flat = 0;
  for (int l = 0; l < 8; l++) flat += id[l] == PKTRT_NONE && tri[l] < PKTRT__AGAIN;
  return flat;
}

/* Writes vertices and ids of a block. Returns the number of triangles without area at any time: between two keys the
   normal is a quadratic function of time; if it is zero at both and half-way, it is zero throughout. */
static uint32_t pktrt__block_write(const pktrt__fit_table *fit, const pktrt__bvh *bvh, uint32_t block,
                                   const pktrt__block_source *s) {
  const uint32_t *tri = bvh->block_triangles + (size_t)block * 8;
  pktrt__block *at = pktrt__bvh_block(bvh, block);
  uint32_t *id = at->id, area = 0;
  float middle[72];
  for (uint32_t k = 0; k < bvh->key_count; k++) {
    float *v = pktrt__block_vertices(at, k);
    for (uint32_t l = 0; l < 8; l++) {
      const float *p = s->corner[l][0] + k * s->step[l], *q = s->corner[l][1] + k * s->step[l];
      const float *r = s->corner[l][2] + k * s->step[l];
      v[l] = p[0], v[8 + l] = p[1], v[16 + l] = p[2];
      v[24 + l] = q[0], v[32 + l] = q[1], v[40 + l] = q[2];
      v[48 + l] = r[0], v[56 + l] = r[1], v[64 + l] = r[2];
    }
    if (area != 0xFF) area |= fit->lanes_with_area(v);
    if (area == 0xFF || !k) continue;
    const float *before = pktrt__block_vertices(at, k - 1);
    for (int i = 0; i < 72; i++) middle[i] = 0.5f * before[i] + 0.5f * v[i];
    area |= fit->lanes_with_area(middle);
  }
  for (uint32_t l = 0; l < 8; l++) id[l] = tri[l] != PKTRT_NONE && area >> l & 1 ? tri[l] & ~PKTRT__AGAIN : PKTRT_NONE;
  return pktrt__block_count_degenerate(tri, id);
}

/* Bounds */

static float pktrt__min8(const float *p) {
  float m[4];
  for (int i = 0; i < 4; i++) m[i] = p[i] < p[i + 4] ? p[i] : p[i + 4];
  m[0] = m[0] < m[2] ? m[0] : m[2], m[1] = m[1] < m[3] ? m[1] : m[3];
  return m[0] < m[1] ? m[0] : m[1];
}
static float pktrt__max8(const float *p) {
  float m[4];
  for (int i = 0; i < 4; i++) m[i] = p[i] > p[i + 4] ? p[i] : p[i + 4];
  m[0] = m[0] > m[2] ? m[0] : m[2], m[1] = m[1] > m[3] ? m[1] : m[3];
  return m[0] > m[1] ? m[0] : m[1];
}

/* Unites the children's boxes of a node at a key: lo x, hi x, lo y, ... The bounds of empty children change nothing. */
static void pktrt__bvh_node_box(const pktrt__bvh *bvh, uint32_t node, uint32_t key, float box[6]) {
  const float *plane = pktrt__node_planes(pktrt__bvh_node(bvh, node), key);
  for (int a = 0; a < 3; a++) {
    box[2 * a] = pktrt__min8(plane + 16 * a);
    box[2 * a + 1] = pktrt__max8(plane + 16 * a + 8);
  }
}

static double pktrt__bvh_box_area(const float box[6]) {
  double x = (double)box[1] - box[0], y = (double)box[3] - box[2], z = (double)box[5] - box[4];
  return x < 0 ? 0 : 2.0 * (x * y + y * z + z * x); /* 0: of nothing */
}

/* Returns an integer that orders as x does but for its last three bits, which hold i < 8: no two are equal. */
PKTRT__INLINE int32_t pktrt__bvh_order_key(float x, int32_t i) {
  int32_t bits;
  memcpy(&bits, &x, 4);
  return ((bits < 0 ? bits ^ INT32_MAX : bits) & ~7) | i;
}

/* Orders children from far to near for each octant, at the middle of the motion. Opposite octants have reverse ones. */
PKTRT__INLINE void pktrt__bvh_order_children(const pktrt__bvh *bvh, pktrt__node *node) {
  const float *p = pktrt__node_planes(node, (bvh->key_count - 1) / 2),
              *q = pktrt__node_planes(node, bvh->key_count / 2);
  float c[3][8];
  for (int a = 0; a < 3; a++) {
    for (int i = 0; i < 8; i++) c[a][i] = p[16 * a + i] + p[16 * a + 8 + i] + (q[16 * a + i] + q[16 * a + 8 + i]);
  }
  for (uint32_t octant = 0; octant < 4; octant++) {
    int32_t distant[8], rank[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int i = 0; i < 8; i++) {
      float x = octant & 1 ? -c[0][i] : c[0][i], y = octant & 2 ? -c[1][i] : c[1][i];
      distant[i] = pktrt__bvh_order_key(x + y + c[2][i], i);
    }
    for (int i = 0; i < 8; i++) {
      for (int j = 0; j < 8; j++) rank[j] += distant[i] > distant[j];
    }
    uint32_t order = 0, reverse = 0;
    for (uint32_t i = 0; i < 8; i++) order |= i << 3 * rank[i], reverse |= i << (21 - 3 * rank[i]);
    node->order[octant] = order, node->order[octant ^ 7] = reverse;
  }
}

/* A run's contribution to the figures of its tree: kept behind the tree's tasks, that of the top last. */
typedef struct pktrt__bvh_sum {
  double area;
  uint32_t degenerate, changed;
} pktrt__bvh_sum;

static pktrt__bvh_sum *pktrt__bvh_sums(const pktrt__bvh *bvh) {
  return PKTRT__CAST(pktrt__bvh_sum *, PKTRT__CAST(void *, bvh->tasks + bvh->task_count + 1));
}
static bool pktrt__bvh_alloc_tasks(const pktrt_scene_desc *desc, pktrt__bvh *bvh) {
  bvh->tasks = PKTRT__CAST(pktrt__bvh_task *, pktrt__mem_alloc(desc, (uint64_t)bvh->task_count + 1,
                                                               sizeof(pktrt__bvh_task) + sizeof(pktrt__bvh_sum)));
  return bvh->tasks != NULL;
}

/* Computes bounds, cost and counts of a tree from its root and the runs. The cost is the expected number of nodes and
   blocks opened by a random line through the root's box, at a random time: areas of all of them over the root's, each
   summed over the keys. For boxes without area it is 2, as for a root with one block. */
PKTRT__COLD void pktrt__bvh_sum_up(pktrt__bvh *bvh) {
  double root = 0.0, sum = 0.0;
  for (uint32_t k = 0; k < bvh->key_count; k++) {
    float box[6];
    pktrt__bvh_node_box(bvh, 0, k, box);
    for (int a = 0; a < 3; a++) {
      if (k == 0 || box[2 * a] < bvh->lo[a]) bvh->lo[a] = box[2 * a];
      if (k == 0 || box[2 * a + 1] > bvh->hi[a]) bvh->hi[a] = box[2 * a + 1];
    }
    root += pktrt__bvh_box_area(box);
  }
  bvh->degenerate_count = 0;
  for (uint32_t i = 0; i <= bvh->task_count; i++) {
    sum += pktrt__bvh_sums(bvh)[i].area;
    bvh->degenerate_count += pktrt__bvh_sums(bvh)[i].degenerate;
  }
  bvh->sah_now = root > 0.0 ? (root + sum) / root : 2.0;
  float swept[6];
  for (int a = 0; a < 3; a++) swept[2 * a] = bvh->lo[a], swept[2 * a + 1] = bvh->hi[a];
  bvh->area = pktrt__bvh_box_area(swept);
}

/* Collapse */

typedef struct pktrt__collapse_subtree { /* a subtree of the binary tree */
  uint32_t slot, first, count;
} pktrt__collapse_subtree;

typedef struct pktrt__collapse_walk {
  const pktrt__builder *b;
  pktrt__bvh *bvh;               /* the tree written; NULL: count only */
  pktrt__collapse_subtree *subs; /* roots of the tasks, in order; NULL: count only */
  uint32_t task_count;           /* tasks found so far */
  uint32_t limit;                /* inner subtrees of up to so many triangles are tasks; 0: none is */
} pktrt__collapse_walk;

/* Lists the children of a wide node as planned; returns how many. */
static uint32_t pktrt__collapse_open(const pktrt__build_node *nodes, pktrt__collapse_subtree root,
                                     pktrt__collapse_subtree child[8]) {
  struct {
    pktrt__collapse_subtree sub;
    uint32_t most;
  } stack[8];
  uint32_t n = 0, top = 0;
  stack[top].sub = root, stack[top++].most = 8;
  while (top) {
    const pktrt__collapse_subtree part = stack[--top].sub;
    const pktrt__build_node *node = &nodes[part.slot];
    const uint32_t most = stack[top].most, share = most > 1 ? node->plan >> 3 * (most - 2) & 7 : 0, left = node->left;
    if (!left || !share) {
      child[n++] = part;
      continue;
    }
    stack[top].sub.slot = part.slot + 2 * left, stack[top].sub.first = part.first + left;
    stack[top].sub.count = part.count - left, stack[top++].most = most - share;
    stack[top].sub.slot = part.slot + 1, stack[top].sub.first = part.first;
    stack[top].sub.count = left, stack[top++].most = share;
  }
  return n;
}

/* Sorts children so that large boxes of few triangles come last: any-hit traversal enters children from the last to the
   first. WHY: ambient occlusion in conference opens 3.3 nodes a ray, not 8.3 as in the order of the splits. */
static void pktrt__collapse_order_children(const pktrt__build_node *nodes, pktrt__collapse_subtree *child, uint32_t n) {
  pktrt__collapse_subtree from[8];
  double key[8];
  uint32_t rank[8];
  for (uint32_t i = 0; i < n; i++) {
    uint32_t mine = 0;
    const double size = nodes[child[i].slot].size, area = size * size;
    key[i] = area * area / child[i].count;
    for (uint32_t j = 0; j < i; j++) {
      const uint32_t before = key[j] <= key[i];
      mine += before, rank[j] += 1 - before;
    }
    from[i] = child[i], rank[i] = mine;
  }
  for (uint32_t i = 0; i < n; i++) child[rank[i]] = from[i];
}

static void pktrt__bvh_clear_node(const pktrt__bvh *bvh, pktrt__node *node) {
  for (int c = 0; c < 8; c++) node->child[c] = PKTRT__EMPTY;
  for (uint32_t k = 0; k < bvh->key_count; k++) {
    float *plane = pktrt__node_planes(node, k);
    for (int i = 0; i < 48; i++) plane[i] = i & 8 ? -PKTRT__FAR : PKTRT__FAR;
  }
}

/* Writes which triangles a block has, each once, and of a tree with split ones its box. */
static void pktrt__collapse_write_leaf(const pktrt__collapse_walk *w, pktrt__collapse_subtree leaf, uint32_t block,
                                       float *plane) {
  uint32_t *tri = w->bvh->block_triangles + (size_t)block * 8, n = 0;
  const pktrt__build_prim *p = w->b->prims + leaf.first;
  const float unscale = 1 / w->b->scale;
  float box[8];
  pktrt__build_box_clear(box);
  for (uint32_t l = 0; l < leaf.count; l++) {
    const uint32_t id = pktrt__build_prim_id(&p[l]);
    uint32_t same = w->bvh->split ? 0 : n;
    while (same < n && (tri[same] ^ id) << 1) same++;
    if (same < n) tri[same] &= id;
    else tri[n++] = id;
    if (w->bvh->split) pktrt__build_box_grow(box, p[l].box);
  }
  while (n < 8) tri[n++] = PKTRT_NONE;
  for (int a = 0; w->bvh->split && a < 3; a++)
    plane[16 * a] = box[a] * unscale, plane[16 * a + 8] = -box[a + 4] * unscale;
}

/* Walks the wide tree below root in depth-first order, numbers its nodes and blocks from the first ones in *t on, and
   counts them in *t. Writes them, without bounds and vertices, where w->bvh is not NULL. */
static void pktrt__collapse_walk_tree(pktrt__collapse_walk *w, pktrt__collapse_subtree root, pktrt__bvh_task *t) {
  struct {
    pktrt__collapse_subtree sub;
    uint32_t *ref;
  } stack[PKTRT__STACK];
  uint32_t top = 0, node = t->first_node, block = t->first_block, ignored = 0;
  stack[top].sub = root, stack[top++].ref = &ignored;
  while (top) {
    pktrt__collapse_subtree child[8], sub = stack[--top].sub;
    uint32_t n = pktrt__collapse_open(w->b->nodes, sub, child), *refs = &ignored;
    float *planes = NULL;
    if (w->bvh || w->subs) pktrt__collapse_order_children(w->b->nodes, child, n);
    if (w->bvh) {
      pktrt__node *at = pktrt__bvh_node(w->bvh, node);
      pktrt__bvh_clear_node(w->bvh, at);
      refs = at->child, planes = at->plane[0];
      *stack[top].ref = node;
    }
    node++;
    for (uint32_t c = 0; c < n; c++) {
      uint32_t *ref = w->bvh ? &refs[c] : &ignored;
      if (!w->b->nodes[child[c].slot].left) {
        if (w->bvh) pktrt__collapse_write_leaf(w, child[c], block, planes + c);
        *ref = PKTRT__LEAF | block++;
      } else if (child[c].count <= w->limit) {
        if (w->subs) w->subs[w->task_count] = child[c];
        if (w->bvh) *ref = w->bvh->tasks[w->task_count].first_node;
        w->task_count++;
      } else {
        stack[top].sub = child[c], stack[top++].ref = ref;
      }
    }
  }
  t->node_count = node - t->first_node, t->block_count = block - t->first_block;
}

typedef struct pktrt__collapse {
  pktrt__builder *b;
  pktrt__bvh *bvh;
  pktrt__collapse_subtree *subs;
} pktrt__collapse;

static void pktrt__collapse_count_job(void *arg, size_t i) {
  pktrt__collapse *c = PKTRT__CAST(pktrt__collapse *, arg);
  pktrt__collapse_walk w = {c->b, NULL, NULL, 0, 0};
  pktrt__collapse_walk_tree(&w, c->subs[i], &c->bvh->tasks[i]);
}

static uint32_t pktrt__block_write_run(const pktrt__builder *b, const pktrt__bvh *bvh, const pktrt__bvh_task *t) {
  pktrt__block_source ahead[PKTRT__AHEAD];
  pktrt__mesh_reader reader = pktrt__mesh_reader_make(b->meshes, b->mesh_count, b->use_pending, b->hides);
  uint32_t flat = 0;
  for (uint32_t i = 0; i < t->block_count + PKTRT__AHEAD; i++) {
    pktrt__block_source *s = &ahead[i % PKTRT__AHEAD];
    if (i >= PKTRT__AHEAD) flat += pktrt__block_write(b->fit, bvh, t->first_block + i - PKTRT__AHEAD, s);
    if (i < t->block_count)
      pktrt__block_find_source(bvh, t->first_block + i, t->first_block + t->block_count, &reader, s);
  }
  return flat;
}

static void pktrt__collapse_write_job(void *arg, size_t i) {
  pktrt__collapse *c = PKTRT__CAST(pktrt__collapse *, arg);
  pktrt__collapse_walk w = {c->b, c->bvh, NULL, 0, 0};
  pktrt__bvh_task *t = &c->bvh->tasks[i];
  pktrt__bvh_sum *sum = &pktrt__bvh_sums(c->bvh)[i];
  pktrt__collapse_walk_tree(&w, c->subs[i], t);
  sum->degenerate = pktrt__block_write_run(c->b, c->bvh, t);
  sum->area = c->b->fit->nodes(c->bvh, t->first_node, t->node_count);
}

/* Allocates nodes and blocks, whose counts are known, and places the runs, the top first. */
static bool pktrt__collapse_place_tasks(const pktrt_scene_desc *desc, pktrt__bvh *bvh) {
  const pktrt__bvh_task *top = &bvh->tasks[bvh->task_count];
  bvh->node_count = top->node_count, bvh->block_count = top->block_count;
  for (uint32_t i = 0; i < bvh->task_count; i++) {
    bvh->tasks[i].first_node = bvh->node_count, bvh->tasks[i].first_block = bvh->block_count;
    bvh->node_count += bvh->tasks[i].node_count, bvh->block_count += bvh->tasks[i].block_count;
  }
  bvh->nodes = PKTRT__CAST(unsigned char *, pktrt__mem_alloc(desc, bvh->node_count, bvh->node_bytes));
  bvh->blocks = PKTRT__CAST(unsigned char *, pktrt__mem_alloc(desc, bvh->block_count, bvh->block_bytes));
  bvh->block_triangles =
      PKTRT__CAST(uint32_t *, pktrt__mem_alloc(desc, (uint64_t)bvh->block_count * 8, sizeof(uint32_t)));
  return bvh->nodes && bvh->blocks && bvh->block_triangles;
}

/* Collapses the binary tree into the wide one; on failure the caller frees what *bvh holds. */
static bool pktrt__collapse_build(pktrt__builder *b, pktrt__bvh *bvh) {
  const pktrt_scene_desc *desc = b->desc;
  pktrt__collapse_subtree root = {0, 0, b->count};
  pktrt__bvh_task top = {0, 0, 0, 0};
  pktrt__collapse_walk w = {b, NULL, NULL, 0, b->limit};
  bool one = b->count <= b->limit;
  if (!one) pktrt__collapse_walk_tree(&w, root, &top);
  uint32_t count = bvh->task_count = one ? 1 : w.task_count;
  if (!pktrt__bvh_alloc_tasks(desc, bvh)) return false;
  memset(bvh->tasks, 0, (bvh->task_count + (size_t)1) * (sizeof(pktrt__bvh_task) + sizeof(pktrt__bvh_sum)));
  pktrt__collapse c = {
      b, bvh, PKTRT__CAST(pktrt__collapse_subtree *, pktrt__mem_alloc(desc, count, sizeof(pktrt__collapse_subtree)))};
  if (!c.subs) return false;
  c.subs[0] = root;
  w.subs = c.subs, w.task_count = 0;
  if (!one) pktrt__collapse_walk_tree(&w, root, &top);
  bvh->tasks[count] = top;
  pktrt__parallel_for(desc, count, pktrt__collapse_count_job, &c);
  bool ok = pktrt__collapse_place_tasks(desc, bvh);
  if (ok) {
    pktrt__parallel_for(desc, count, pktrt__collapse_write_job, &c);
    pktrt__bvh_sum *sum = &pktrt__bvh_sums(bvh)[count];
    w.subs = NULL, w.bvh = bvh, w.task_count = 0;
    if (!one) pktrt__collapse_walk_tree(&w, root, &top);
    sum->degenerate = pktrt__block_write_run(b, bvh, &top);
    sum->area = b->fit->nodes(bvh, 0, top.node_count);
  }
  pktrt__mem_release(desc, c.subs, count, sizeof(pktrt__collapse_subtree));
  return ok;
}
static void pktrt__bvh_free(const pktrt_scene_desc *desc, pktrt__bvh *bvh) {
  pktrt__mem_release(desc, bvh->nodes, bvh->node_count, bvh->node_bytes);
  pktrt__mem_release(desc, bvh->blocks, bvh->block_count, bvh->block_bytes);
  pktrt__mem_release(desc, bvh->block_triangles, (uint64_t)bvh->block_count * 8, sizeof(uint32_t));
  pktrt__mem_release(desc, bvh->tasks, (uint64_t)bvh->task_count + 1, sizeof(pktrt__bvh_task) + sizeof(pktrt__bvh_sum));
  memset(bvh, 0, sizeof *bvh);
}

static void pktrt__build_set_quality(pktrt__builder *b) {
  b->sampled = 2048;
  switch (b->desc->quality) {
  case PKTRT_BUILD_FAST: b->bins = 12, b->few_bins = 8, b->few = b->many = 32, b->sweep = 8; break;
  case PKTRT_BUILD_HIGH:
    b->passes = 2;
    b->bins = b->few_bins = 64, b->few = b->many = 0, b->sweep = PKTRT__MAX_SWEEP, b->sampled = UINT32_MAX;
    break;
  default: b->bins = 32, b->few_bins = 8, b->few = 64, b->many = 512, b->sweep = 16; break;
  }
}

/* Returns how many prims the triangles of a set may be split into. WHY none of what deforms, or is hidden: refits would
   widen boxes of parts to those of whole triangles. */
PKTRT__COLD uint64_t pktrt__split_room(const pktrt_scene *s, uint32_t set_index) {
  const pktrt__set *set = &s->sets[set_index];
  const uint64_t count = set->triangles, room = count + count / 6;
  bool may = s->desc.quality == PKTRT_BUILD_HIGH && !s->of_boxes && !pktrt__has_motion(set->key_count) && !set->hides;
  for (uint32_t i = set->first_mesh; i < set->end_mesh; i++)
    may = may && (s->meshes[i].set != set_index || !s->meshes[i].pending);
  return may && room < PKTRT__LEAF ? room : count;
}

/* Builds the tree over a set of meshes, which are not empty. False: no memory, *out stays as is. */
static bool pktrt__build_bvh(const pktrt_scene *s, uint32_t set_index, bool use_pending, pktrt__bvh *out) {
  const pktrt_scene_desc *desc = &s->desc;
  const pktrt__set *set = &s->sets[set_index];
  const uint32_t key_count = set->key_count;
  const uint64_t count = pktrt__split_room(s, set_index);
  pktrt__builder b;
  pktrt__bvh bvh;
  if (count >= PKTRT__LEAF) return false; /* no room for as many blocks in a reference */
  memset(&b, 0, sizeof b), memset(&bvh, 0, sizeof bvh);
  b.desc = desc, b.fit = pktrt__fit_table_of(desc->isa);
  b.meshes = s->meshes, b.mesh_count = s->mesh_count, b.first_mesh = set->first_mesh, b.end_mesh = set->end_mesh;
  b.set = bvh.set = set_index, b.key_count = key_count, b.use_pending = use_pending, b.hides = set->hides;
  b.count = bvh.triangle_count = set->triangles, bvh.mask = set->mask, b.room = (uint32_t)count;
  b.limit = b.count / PKTRT__TASK_PARTS;
  if (b.limit < PKTRT__TASK_MIN) b.limit = PKTRT__TASK_MIN;
  pktrt__build_set_quality(&b);
  bvh.key_count = key_count;
  bvh.node_bytes = PKTRT__NODE_BYTES + (key_count - 1) * PKTRT__NODE_KEY_BYTES;
  bvh.block_bytes = PKTRT__BLOCK_BYTES + (key_count - 1) * PKTRT__BLOCK_KEY_BYTES;
  uint64_t ranges = pktrt__build_most_done(&b) + 3 * pktrt__build_most_wide(&b),
           chunks = (count + PKTRT__CHUNK - 1) / PKTRT__CHUNK;
  if (ranges < chunks) ranges = chunks;
  b.prims = PKTRT__CAST(pktrt__build_prim *, pktrt__mem_alloc(desc, count, sizeof(pktrt__build_prim)));
  b.away = PKTRT__CAST(pktrt__build_prim *, pktrt__mem_alloc(desc, count, sizeof(pktrt__build_prim)));
  b.nodes = PKTRT__CAST(pktrt__build_node *, pktrt__mem_alloc(desc, 2 * count, sizeof(pktrt__build_node)));
  b.chunks = PKTRT__CAST(pktrt__build_range *, pktrt__mem_alloc(desc, ranges, sizeof(pktrt__build_range)));
  bool ok = b.prims && b.away && b.nodes && b.chunks && pktrt__build_binary_tree(&b);
  bvh.split = b.count > bvh.triangle_count;
  pktrt__mem_release(desc, b.away, count, sizeof(pktrt__build_prim)); /* makes room for what follows */
  ok = ok && pktrt__collapse_build(&b, &bvh);
  pktrt__mem_release(desc, b.prims, count, sizeof(pktrt__build_prim));
  pktrt__mem_release(desc, b.nodes, 2 * count, sizeof(pktrt__build_node));
  pktrt__mem_release(desc, b.chunks, ranges, sizeof(pktrt__build_range));
  if (!ok) {
    pktrt__bvh_free(desc, &bvh);
    return false;
  }
  pktrt__bvh_sum_up(&bvh);
  bvh.sah_at_build = bvh.sah_now, bvh.split = false;
  *out = bvh;
  return true;
}

/* >>refit ---------------------------------------------------------------------------------------------------------- */

/* A refit goes through the runs of the build: it rewrites blocks with a triangle of a changed mesh, then all bounds of
   runs with such a block, then those of the top. A run without one keeps its bounds and its sums. Blocks of split
   triangles are bounded by all of these then: right, but larger. The next build does not split what has moved. */

typedef struct pktrt__refit {
  const pktrt__fit_table *fit;
  pktrt__bvh *bvh;
  const pktrt__mesh *meshes;
  uint32_t mesh_count;
  bool all, hides; /* every mesh of the tree changed; some are hidden */
} pktrt__refit;

/* Tells whether a refit must look at a mesh's triangles. */
PKTRT__INLINE bool pktrt__mesh_moves(const pktrt__mesh *m) { return m->dirty || m->hide != m->hidden; }

static bool pktrt__refit_block_changed(const pktrt__refit *r, uint32_t block) {
  const uint32_t *tri = r->bvh->block_triangles + (size_t)block * 8;
  uint32_t mesh = 0;
  for (int l = 0; l < 8 && !r->all && tri[l] != PKTRT_NONE; l++) {
    mesh = pktrt__mesh_of_triangle(r->meshes, r->mesh_count, tri[l] & ~PKTRT__AGAIN, mesh);
    if (pktrt__mesh_moves(&r->meshes[mesh])) return true;
  }
  return r->all;
}

static void pktrt__refit_blocks(const pktrt__refit *r, const pktrt__bvh_task *t, pktrt__bvh_sum *sum) {
  pktrt__block_source ahead[PKTRT__AHEAD];
  pktrt__mesh_reader reader = pktrt__mesh_reader_make(r->meshes, r->mesh_count, true, r->hides);
  uint32_t waiting[PKTRT__AHEAD], found = 0, done = 0, block = t->first_block, end = block + t->block_count;
  while (block < end || done < found) {
    if (block == end || found - done == PKTRT__AHEAD) {
      const uint32_t which = done++ % PKTRT__AHEAD, *tri = r->bvh->block_triangles + (size_t)waiting[which] * 8;
      const uint32_t flat = pktrt__block_count_degenerate(tri, pktrt__bvh_block(r->bvh, waiting[which])->id);
      sum->degenerate += pktrt__block_write(r->fit, r->bvh, waiting[which], &ahead[which]) - flat;
    }
    for (; block < end && found - done < PKTRT__AHEAD; block++) {
      if (!pktrt__refit_block_changed(r, block)) continue;
      waiting[found % PKTRT__AHEAD] = block;
      pktrt__block_find_source(r->bvh, block, end, &reader, &ahead[found++ % PKTRT__AHEAD]);
    }
  }
  sum->changed = found;
}

static void pktrt__refit_job(void *arg, size_t i) {
  pktrt__refit *r = PKTRT__CAST(pktrt__refit *, arg);
  pktrt__bvh_task *t = &r->bvh->tasks[i];
  pktrt__bvh_sum *sum = &pktrt__bvh_sums(r->bvh)[i];
  pktrt__refit_blocks(r, t, sum);
  if (sum->changed) sum->area = r->fit->nodes(r->bvh, t->first_node, t->node_count);
}

static void pktrt__refit_bvh(const pktrt_scene *s, pktrt__bvh *bvh) {
  const pktrt_scene_desc *desc = &s->desc;
  const pktrt__set *set = &s->sets[bvh->set];
  pktrt__refit r = {pktrt__fit_table_of(desc->isa), bvh, s->meshes, s->mesh_count, true, set->hides};
  for (uint32_t i = set->first_mesh; i < set->end_mesh; i++)
    r.all = r.all && (s->meshes[i].set != bvh->set || pktrt__mesh_moves(&s->meshes[i]));
  const pktrt__bvh_task *top = &bvh->tasks[bvh->task_count];
  pktrt__bvh_sum *sums = pktrt__bvh_sums(bvh);
  pktrt__parallel_for(desc, bvh->task_count, pktrt__refit_job, &r);
  pktrt__refit_blocks(&r, top, &sums[bvh->task_count]);
  bool changed = false;
  for (uint32_t i = 0; i <= bvh->task_count; i++) changed = changed || sums[i].changed;
  if (!changed) return;
  sums[bvh->task_count].area = r.fit->nodes(bvh, top->first_node, top->node_count);
  pktrt__bvh_sum_up(bvh);
}

/* >>validate ------------------------------------------------------------------------------------------------------- */

/* Keeps the sentence that says what was wrong, and returns the status. */
PKTRT__COLD pktrt_status pktrt__fail(pktrt_scene *s, pktrt_status status, const char *format, ...) {
  va_list args;
  va_start(args, format);
  (void)vsnprintf(s->error, sizeof s->error, format, args);
  va_end(args);
  return status;
}

/* Passes a sentence to the log hook. WHY brackets: log is a macro of <tgmath.h>. */
static void pktrt__log_sentence(const pktrt_scene *s, int level, const char *sentence) {
  if (s->desc.log) (s->desc.log)(s->desc.user, level, sentence);
}

#ifndef PKTRT_NO_RENDER
/* The sentence about what is wrong with a render, where the caller wants it. */
typedef struct pktrt__refusal {
  char text[160];
} pktrt__refusal;

static bool pktrt__render_refuse(pktrt__refusal *why, const char *format, ...) { /* always false */
  va_list args;
  va_start(args, format);
  (void)vsnprintf(why->text, sizeof why->text, format, args);
  va_end(args);
  return false;
}
#endif

PKTRT__INLINE bool pktrt__is_finite(float x) { return x - x == 0; } /* false for NaN and infinities */

/* Returns the largest absolute value, NaN if there is one. Compares floats without signs as integers, which order
   alike, NaN last; by eights, which compilers turn into vectors. */
static float pktrt__mesh_largest(const float *p, uint64_t n) {
  int32_t most[8] = {0, 0, 0, 0, 0, 0, 0, 0}, x[8] = {0, 0, 0, 0, 0, 0, 0, 0};
  for (uint64_t i = 0; i < n; i += 8) {
    if (n - i >= 8) memcpy(x, p + i, sizeof x);
    else memcpy(x, p + i, (size_t)(n - i) * sizeof *x);
    for (int k = 0; k < 8; k++) x[k] &= INT32_MAX;
    for (int k = 0; k < 8; k++) most[k] = x[k] > most[k] ? x[k] : most[k];
  }
  for (int k = 1; k < 8; k++) most[0] = most[k] > most[0] ? most[k] : most[0];
  float result;
  memcpy(&result, most, sizeof result);
  return result;
}

/* The caller's vectors: one key of a mesh's positions or normals. */
typedef struct pktrt__mesh_vectors {
  const float *from;
  uint32_t count, stride; /* bytes from one to the next */
  float limit;            /* the largest absolute value allowed */
  uint32_t mesh, key;     /* named in messages */
  const char *what;       /* "vertex", "normal" */
} pktrt__mesh_vectors;

/* Copies vectors from a strided array into a tight one; refuses values that are not finite or too large. */
static pktrt_status pktrt__mesh_copy_vectors(pktrt_scene *s, float *to, const pktrt__mesh_vectors *v) {
  const unsigned char *p = (const unsigned char *)(const void *)v->from;
  if (v->stride == 12 && v->count) {
    memcpy(to, p, (size_t)v->count * 12);
    if (pktrt__mesh_largest(to, (uint64_t)v->count * 3) <= v->limit) return PKTRT_OK;
  }
  for (uint32_t i = 0; i < v->count; i++, p += v->stride, to += 3) {
    memcpy(to, p, 3 * sizeof(float));
    for (int a = 0; a < 3; a++) {
      if (!pktrt__is_finite(to[a]))
        return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u, key %u, %s %u: %c is %s", (unsigned)v->mesh,
                           (unsigned)v->key, v->what, (unsigned)i, 'x' + a, to[a] != to[a] ? "NaN" : "infinite");
      if (fabsf(to[a]) > v->limit)
        return pktrt__fail(s, PKTRT_LIMIT, "mesh %u, key %u, %s %u: %c is %g, beyond the limit of %g",
                           (unsigned)v->mesh, (unsigned)v->key, v->what, (unsigned)i, 'x' + a, (double)to[a],
                           (double)v->limit);
    }
  }
  return PKTRT_OK;
}

static uint64_t pktrt__mesh_floats(const pktrt__mesh *m) { return (uint64_t)m->vertex_count * m->key_count * 3; }

PKTRT__COLD void pktrt__mesh_free(const pktrt_scene_desc *d, pktrt__mesh *m) {
  pktrt__mem_release(d, m->positions, pktrt__mesh_floats(m), sizeof(float));
  pktrt__mem_release(d, m->normals, pktrt__mesh_floats(m), sizeof(float));
  pktrt__mem_release(d, m->texcoords, (uint64_t)m->vertex_count * 2, sizeof(float));
  pktrt__mem_release(d, m->pending, pktrt__mesh_floats(m), sizeof(float));
  pktrt__mem_release(d, m->pending_normals, pktrt__mesh_floats(m), sizeof(float));
  pktrt__mem_release(d, m->indices, (uint64_t)m->triangle_count * 3, sizeof(uint32_t));
}

/* Makes room for one more element; returns false when out of memory, and changes nothing then. */
PKTRT__COLD bool pktrt__mem_grow(const pktrt_scene_desc *d, void **array, uint32_t count, uint32_t *capacity,
                                 size_t size) {
  if (count < *capacity) return true;
  const uint32_t more = *capacity ? *capacity * 2 : 8;
  void *p = more > *capacity ? pktrt__mem_alloc(d, more, size) : NULL;
  if (!p) return false;
  if (count) memcpy(p, *array, count * size);
  pktrt__mem_release(d, *array, *capacity, size);
  *array = p, *capacity = more;
  return true;
}

/* Checks the description of a mesh alone, without reading its arrays. */
PKTRT__COLD pktrt_status pktrt__mesh_check(pktrt_scene *s, const pktrt_mesh_desc *d, uint32_t mesh) {
  const unsigned m = (unsigned)mesh;
  if (!d) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u: the description is NULL", m);
  if (!PKTRT__MOTION && d->key_count > 1)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u: %u motion keys, but this build has PKTRT_NO_MOTION", m,
                       (unsigned)d->key_count);
  if (d->key_count > PKTRT_MAX_KEYS)
    return pktrt__fail(s, PKTRT_LIMIT, "mesh %u: key_count %u is above %u", m, (unsigned)d->key_count, PKTRT_MAX_KEYS);
  if (!PKTRT__GROUPS && (d->group || d->mask))
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u has a %s, but this build has PKTRT_NO_GROUPS", m,
                       d->group ? "group" : "mask");
  if (!PKTRT__SURFACES && d->texcoords)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u has texcoords, but this build has PKTRT_NO_SURFACES", m);
  if (d->position_stride && (d->position_stride < 12 || d->position_stride % 4))
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT,
                       "mesh %u: position_stride %u is neither 0 nor a multiple of 4 from 12 on", m,
                       (unsigned)d->position_stride);
  if (!d->positions && d->vertex_count)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u: positions is NULL, but vertex_count is %u", m,
                       (unsigned)d->vertex_count);
  if (!d->vertex_count && d->triangle_count)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u: %u triangles, but no vertices", m,
                       (unsigned)d->triangle_count);
  const uint64_t bytes = (uint64_t)d->vertex_count * (d->position_stride ? d->position_stride : 12); /* < 2^64 */
  if (bytes > SIZE_MAX / 4 / (d->key_count ? d->key_count : 1))
    return pktrt__fail(s, PKTRT_LIMIT, "mesh %u: %u vertices of stride %u at %u keys are more than memory can hold", m,
                       (unsigned)d->vertex_count, (unsigned)d->position_stride, (unsigned)d->key_count);
  if (d->triangle_count > PKTRT_MAX_TRIANGLES - s->total_triangles)
    return pktrt__fail(s, PKTRT_LIMIT, "mesh %u: %u triangles more than the %u of the scene pass %u", m,
                       (unsigned)d->triangle_count, (unsigned)s->total_triangles, PKTRT_MAX_TRIANGLES);
  if (!d->indices && (uint64_t)d->triangle_count * 3 > d->vertex_count)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT,
                       "mesh %u: a soup of %u triangles needs %llu vertices, vertex_count is %u", m,
                       (unsigned)d->triangle_count, 3ull * d->triangle_count, (unsigned)d->vertex_count);
  return PKTRT_OK;
}

static pktrt_status pktrt__mesh_copy(pktrt_scene *s, const pktrt_mesh_desc *d, pktrt__mesh *m, uint32_t mesh) {
  const uint64_t floats = pktrt__mesh_floats(m);
  m->positions = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, floats, sizeof(float)));
  const bool normals = PKTRT__NORMALS && d->normals;
  if (normals) m->normals = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, floats, sizeof(float)));
  if (d->indices)
    m->indices = PKTRT__CAST(uint32_t *, pktrt__mem_alloc(&s->desc, (uint64_t)d->triangle_count * 3, sizeof(uint32_t)));
  const uint64_t pairs = d->texcoords ? (uint64_t)m->vertex_count * 2 : 0;
  if (pairs) m->texcoords = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, pairs, sizeof(float)));
  if (!m->positions || (normals && !m->normals) || (d->indices && !m->indices) || (pairs && !m->texcoords))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "mesh %u: no memory for %u vertices at %u keys and %u triangles",
                       (unsigned)mesh, (unsigned)m->vertex_count, (unsigned)m->key_count, (unsigned)m->triangle_count);
  for (uint64_t i = 0; d->indices && i < (uint64_t)d->triangle_count * 3; i++) {
    memcpy(&m->indices[i], d->indices + i, sizeof *m->indices);
    if (m->indices[i] >= d->vertex_count)
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u, triangle %u: index %u is not below vertex_count %u",
                         (unsigned)mesh, (unsigned)(i / 3), (unsigned)m->indices[i], (unsigned)d->vertex_count);
  }
  for (uint64_t i = 0; i < pairs; i++) {
    memcpy(&m->texcoords[i], d->texcoords + i, sizeof *m->texcoords);
    if (!pktrt__is_finite(m->texcoords[i]))
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "mesh %u, texcoord %u: %c is %g", (unsigned)mesh, (unsigned)(i / 2),
                         i % 2 ? 'v' : 'u', (double)m->texcoords[i]);
  }
  const uint64_t key_bytes = (uint64_t)m->stride * m->vertex_count;
  for (uint32_t k = 0; m->vertex_count && k < m->key_count; k++) {
    const uint64_t at = (uint64_t)k * m->vertex_count * 3;
    const float *from =
        (const float *)(const void *)((const unsigned char *)(const void *)d->positions + (size_t)(k * key_bytes));
    pktrt__mesh_vectors v = {from, m->vertex_count, m->stride, PKTRT_MAX_COORD, mesh, k, "vertex"};
    pktrt_status st = pktrt__mesh_copy_vectors(s, m->positions + at, &v);
    if (normals) v.from = d->normals + at, v.stride = 12, v.limit = FLT_MAX, v.what = "normal";
    if (st == PKTRT_OK && normals) st = pktrt__mesh_copy_vectors(s, m->normals + at, &v);
    if (st != PKTRT_OK) return st;
  }
  return PKTRT_OK;
}

/* >>commit --------------------------------------------------------------------------------------------------------- */

static void pktrt__commit_swap(float **a, float **b) {
  float *swap = *a;
  *a = *b, *b = swap;
}

/* Takes over the positions and normals that pktrt_set_positions and pktrt_set_normals left pending. */
static void pktrt__commit_promote(pktrt__mesh *m) {
  if (m->dirty && m->pending) pktrt__commit_swap(&m->positions, &m->pending);
  if (m->dirty_normals) pktrt__commit_swap(&m->normals, &m->pending_normals);
  m->dirty = m->dirty_normals = false;
  m->hidden = m->hide;
  m->committed = !m->free;
}
/* Makes a mesh that is gone an index that waits for another. */
PKTRT__COLD void pktrt__mesh_clear(pktrt_scene *s, pktrt__mesh *m) {
  const uint32_t first_id = m->first_id, instance = m->instance;
  if (m->set != PKTRT_NONE) s->sets[m->set].meshes--;
  pktrt__mesh_free(&s->desc, m);
  memset(m, 0, sizeof *m);
  m->first_id = first_id, m->instance = instance, m->set = PKTRT_NONE, m->free = true;
  s->free_meshes += !instance;
}

static pktrt__bvh_segment pktrt__bvh_segment_of(const pktrt__bvh *bvhs, uint32_t index, uint32_t segment);

/* Widens the scene's bounds by those of its instances. */
PKTRT__COLD void pktrt__commit_summarise_instances(pktrt_scene *s) {
  for (uint32_t i = 0; i < s->boxes->committed_meshes; i++)
    s->stretch = pktrt__maxf(s->stretch, (float)((11 + 3 * s->instances[i].kappa) / 16));
  for (int a = 0; a < 3; a++)
    s->lo[a] = pktrt__minf(s->lo[a], s->boxes->lo[a]), s->hi[a] = pktrt__maxf(s->hi[a], s->boxes->hi[a]);
}

/* Derives from the trees their order and first segments, the scene's bounds, and whether a rebuild is advised. */
PKTRT__COLD void pktrt__commit_summarise(pktrt_scene *s) {
  for (uint32_t i = 1; i < s->direct_count; i++) /* insertion sort: few trees */
    for (uint32_t j = i; j > 0 && s->bvhs[j].area < s->bvhs[j - 1].area; j--) {
      const pktrt__bvh swap = s->bvhs[j];
      s->bvhs[j] = s->bvhs[j - 1], s->bvhs[j - 1] = swap;
    }
  s->rebuild_advised = false;
  for (int a = 0; a < 3; a++) s->lo[a] = FLT_MAX, s->hi[a] = -FLT_MAX;
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    pktrt__bvh *bvh = &s->bvhs[i];
    bvh->rest = pktrt__bvh_segment_of(s->bvhs, i, 0), s->sets[bvh->set].tree = i;
    for (int a = 0; a < 3; a++) {
      s->lo[a] = pktrt__minf(s->lo[a], bvh->lo[a]);
      s->hi[a] = pktrt__maxf(s->hi[a], bvh->hi[a]);
    }
    if (s->desc.rebuild != PKTRT_REBUILD_NEVER && bvh->sah_now > 1.5 * bvh->sah_at_build) s->rebuild_advised = true;
  }
  s->stretch = 1, s->largest = 0;
  s->has_top = s->boxes || s->groups;
  s->single_tree = s->bvh_count == 1 && !pktrt__has_motion(s->bvhs->key_count) && !s->has_top;
  if (s->boxes) pktrt__commit_summarise_instances(s);
  for (int a = 0; a < 3 && s->lo[0] <= s->hi[0]; a++)
    s->largest = pktrt__maxf(s->largest, pktrt__maxf(fabsf(s->lo[a]), fabsf(s->hi[a])));
}

/* Finds what each set will have, and whether its tree must be built, or fitted. */
PKTRT__COLD void pktrt__commit_survey(const pktrt_scene *s) {
  for (uint32_t i = 0; i < s->set_count; i++)
    s->sets[i].triangles = 0, s->sets[i].changed = s->sets[i].moved = s->sets[i].hides = false;
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    if (m->set == PKTRT_NONE || !m->triangle_count) continue;
    pktrt__set *set = &s->sets[m->set];
    set->changed = set->changed || m->dirty || m->marked || m->gone || !m->committed;
    set->moved = set->moved || pktrt__mesh_moves(m), set->hides = set->hides || m->hide;
    if (!m->gone) set->triangles += m->triangle_count;
  }
}

/* The trees of the next state of a scene. */
typedef struct pktrt__commit_list {
  pktrt__bvh *bvhs;
  uint32_t n, room, direct;
  pktrt_scene *groups; /* over those that are not direct */
} pktrt__commit_list;
/* Frees the list, and what in it is new. */
PKTRT__COLD void pktrt__commit_drop(const pktrt_scene *s, pktrt__commit_list *list) {
  while (list->n--) {
    const pktrt__bvh *fresh = &list->bvhs[list->n];
    const uint32_t tree = s->sets[fresh->set].tree;
    if (tree == PKTRT_NONE || s->bvhs[tree].nodes != fresh->nodes) pktrt__bvh_free(&s->desc, &list->bvhs[list->n]);
  }
  if (list->groups != s->groups) pktrt_scene_destroy(list->groups);
  pktrt__mem_release(&s->desc, list->bvhs, list->room, sizeof *list->bvhs);
}

/* Returns an empty scene for boxes: of trees, or of instances. NULL: no memory. */
PKTRT__COLD pktrt_scene *pktrt__top_create(const pktrt_scene *s) {
  pktrt_scene_desc d = s->desc;
  d.rebuild = PKTRT_REBUILD_AUTOMATIC, d.log = NULL;
  pktrt_scene *top = pktrt_scene_create(&d);
  if (top) top->of_boxes = true;
  return top;
}
/* Completes the corners of a box to a triangle across it. */
static void pktrt__top_box(float box[9]) {
  for (int a = 0; a < 3; a++) box[6 + a] = a ? box[a] : box[3];
}

/* Computes a triangle across the box of a tree at a key. */
static void pktrt__group_box(const pktrt__bvh *bvh, uint32_t key, float box[9]) {
  const float *plane = pktrt__node_planes(pktrt__bvh_node(bvh, 0), key);
  for (int a = 0; a < 3; a++) {
    box[a] = pktrt__min8(plane + 16 * a), box[3 + a] = pktrt__max8(plane + 16 * a + 8);
    if (!(box[a] <= box[3 + a])) box[a] = box[3 + a] = 0; /* all of it is hidden */
  }
  pktrt__top_box(box);
}
/* Returns the scene of the boxes of trees: a tree above them. NULL: no memory. */
PKTRT__COLD pktrt_scene *pktrt__group_make(const pktrt_scene *s, const pktrt__bvh *bvhs, uint32_t n) {
  pktrt_scene *top = pktrt__top_create(s);
  bool ok = top != NULL;
  for (uint32_t i = 0; ok && i < n; i++) {
    const uint32_t keys = bvhs[i].key_count;
    float *box = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, keys, 9 * sizeof *box));
    pktrt_mesh_desc mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.positions = box, mesh.vertex_count = 3, mesh.triangle_count = 1, mesh.key_count = keys;
    for (uint32_t k = 0; box && k < keys; k++) pktrt__group_box(&bvhs[i], k, box + 9 * (size_t)k);
    ok = box && !pktrt_add_mesh(top, &mesh, NULL);
    pktrt__mem_release(&s->desc, box, keys, 9 * sizeof *box);
  }
  if (ok && !pktrt_commit(top)) return top;
  pktrt_scene_destroy(top);
  return NULL;
}
/* Fits the tree above those that were fitted. */
PKTRT__COLD void pktrt__group_refit(pktrt_scene *s) {
  for (uint32_t i = s->direct_count; i < s->bvh_count; i++) {
    pktrt__mesh *box = &s->groups->meshes[i - s->direct_count];
    if (!s->sets[s->bvhs[i].set].moved) continue;
    for (uint32_t k = 0; k < box->key_count; k++) pktrt__group_box(&s->bvhs[i], k, box->positions + 9 * (size_t)k);
    box->dirty = true;
  }
  (void)pktrt_refit(s->groups);
}

/* How many trees of groups rays visit one after the other. More have a tree above them, which knows no frusta. */
enum { PKTRT__FEW_GROUPS = 4 };

/* Puts the trees of the next state into a list, those of groups last: those that changed anew. */
PKTRT__COLD bool pktrt__commit_list_trees(const pktrt_scene *s, pktrt__commit_list *list, uint32_t *failed) {
  bool same = true; /* those of groups are what and where they were */
  for (int grouped = 0; grouped <= PKTRT__GROUPS; grouped++) {
    for (uint32_t i = 0; i < s->set_count; i++) {
      pktrt__set *set = &s->sets[i];
      const bool kept = set->tree != PKTRT_NONE && !set->changed;
      if ((set->group != 0) != grouped) continue;
      *failed = i, set->next = set->triangles ? list->n : PKTRT_NONE;
      same = same && (!grouped || (set->next == set->tree && !set->changed));
      if (set->triangles && kept) list->bvhs[list->n] = s->bvhs[set->tree];
      else if (set->triangles && !pktrt__build_bvh(s, i, true, &list->bvhs[list->n])) return false;
      list->n += set->triangles != 0;
    }
    if (!grouped) list->direct = list->n;
  }
  if (list->n - list->direct <= PKTRT__FEW_GROUPS) list->direct = list->n;
  if (!PKTRT__GROUPS || list->n == list->direct) return true;
  list->groups = same && list->direct == s->direct_count ? s->groups : NULL;
  if (!list->groups) list->groups = pktrt__group_make(s, list->bvhs + list->direct, list->n - list->direct);
  return list->groups != NULL;
}
/* Builds the trees that changed into a new list; the names in messages are those of `told`. */
PKTRT__COLD pktrt_status pktrt__commit_build_changed(const pktrt_scene *s, pktrt_scene *told,
                                                     pktrt__commit_list *list) {
  uint32_t failed = 0;
  memset(list, 0, sizeof *list);
  pktrt__commit_survey(s);
  for (uint32_t i = 0; i < s->set_count; i++) list->room += s->sets[i].triangles != 0;
  list->bvhs = PKTRT__CAST(pktrt__bvh *, pktrt__mem_alloc(&s->desc, list->room, sizeof *list->bvhs));
  if (!list->bvhs) return pktrt__fail(told, PKTRT_OUT_OF_MEMORY, "commit: no memory for the list of trees");
  if (pktrt__commit_list_trees(s, list, &failed)) return PKTRT_OK;
  pktrt__commit_drop(s, list);
  return pktrt__fail(told, PKTRT_OUT_OF_MEMORY, "commit: no memory to build the tree of the %s with %u key%s",
                     s == told ? "meshes" : "instances", (unsigned)s->sets[failed].key_count,
                     s->sets[failed].key_count > 1 ? "s" : "");
}

/* Fits the trees that are left as they are but for what has moved. */
PKTRT__COLD void pktrt__commit_fit_moved(pktrt_scene *s) {
  bool grouped = false;
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    pktrt__set *set = &s->sets[s->bvhs[i].set];
    if (!set->moved) continue;
    pktrt__refit_bvh(s, &s->bvhs[i]);
    grouped = grouped || i >= s->direct_count;
  }
  if (PKTRT__GROUPS && grouped) pktrt__group_refit(s);
}

/* Makes a list of trees, and what waits for them, the state of a scene. */
PKTRT__COLD void pktrt__commit_take(pktrt_scene *s, const pktrt__commit_list *list) {
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const uint32_t next = s->sets[s->bvhs[i].set].next;
    if (next == PKTRT_NONE || list->bvhs[next].nodes != s->bvhs[i].nodes) pktrt__bvh_free(&s->desc, &s->bvhs[i]);
  }
  pktrt__mem_release(&s->desc, s->bvhs, s->bvh_room, sizeof *s->bvhs);
  s->bvhs = list->bvhs, s->bvh_count = list->n, s->bvh_room = list->room, s->direct_count = list->direct;
  if (list->groups != s->groups) pktrt_scene_destroy(s->groups);
  s->groups = list->groups;
  for (uint32_t i = 0; i < s->set_count; i++)
    s->sets[i].tree = s->sets[i].next, s->sets[i].moved = s->sets[i].moved && !s->sets[i].changed;
  pktrt__commit_fit_moved(s);
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    if (s->meshes[i].gone) pktrt__mesh_clear(s, &s->meshes[i]);
    else pktrt__commit_promote(&s->meshes[i]), s->meshes[i].marked = false;
  }
  s->committed_meshes = s->mesh_count, s->start_shift = 0;
  while (s->total_triangles >> s->start_shift >= PKTRT__STARTS) s->start_shift++;
  for (uint32_t i = 0; i <= PKTRT__STARTS; i++)
    s->starts[i] = pktrt__mesh_search(s->meshes, s->mesh_count, i << s->start_shift);
}

PKTRT__COLD pktrt_status pktrt__commit_rebuild_worn(pktrt_scene *s) {
  if (!s->rebuild_advised) return PKTRT_OK;
  if (s->desc.rebuild == PKTRT_REBUILD_ADVISE)
    pktrt__log_sentence(s, 0,
                        "the deformed tree costs more than 1.5 times what it did when built: a rebuild is advised");
  if (s->desc.rebuild != PKTRT_REBUILD_AUTOMATIC) return PKTRT_OK;
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    pktrt__bvh *bvh = &s->bvhs[i], fresh;
    if (!(bvh->sah_now > 1.5 * bvh->sah_at_build)) continue;
    if (!pktrt__build_bvh(s, bvh->set, false, &fresh)) {
      pktrt__log_sentence(s, 0, "no memory for an automatic rebuild: the refitted tree stays");
      continue;
    }
    pktrt__bvh_free(&s->desc, bvh);
    *bvh = fresh;
    pktrt__log_sentence(s, 1, "a deformed tree was rebuilt");
  }
  pktrt__commit_summarise(s);
  return PKTRT_OK;
}
/* >>exactness --------------------------------------------------------------------------------------------------------

   THE DEFINITION. Rays and vertices are floats, taken at their word: as real numbers. A ray (o, d) has a main axis k,
   that of its largest |d|, the lowest on ties, and u, v, the next two in cyclic order. Relative to o, and sheared so
   that d lies along k, a vertex P is

       p = P - o      x = p_u d_k - p_k d_u      y = p_v d_k - p_k d_v      z = p_k

   so that t = z / d_k where x = y = 0. The edge functions of a triangle a, b, c and their sum,

       U = xc yb - yc xb      V = xa yc - ya xc      W = xb ya - yb xa      D = U + V + W

   tell on which side the ray passes: x_p y_q - y_p x_q = d_k d . (p x q), p and q the corners of an edge. Where that
   is 0 the ray meets the edge's line. It is then taken to be displaced by (e, e^2) in u, v, e being positive and less
   than any number: d . (p x q) becomes less by e ((q - p) x d)_u + e^2 ((q - p) x d)_v, with the sign of the first of

       d . (p x q)      d_v (Q - P)_k - d_k (Q - P)_v      d_k (Q - P)_u - d_u (Q - P)_k

   that is not 0, times that of d_k; all are 0 only for an edge along the ray. Exchanging P and Q changes each sign: what
   one triangle of an edge has on its side the other has not. A ray crosses the triangle where U, V and W have
   one sign. As the displaced ray meets no edge, each crossing of a closed surface, at shared edges and vertices too,
   belongs to one triangle, whatever the triangles are; they cannot leak. One without area has none; a silhouette that
   is touched counts twice or not at all; and by the signs of D a crossing leads in or out.

   The crossing is at t = n . (P - o) / n . d, u = V / D, v = W / D, where nothing is displaced, and is a hit if tmin <
   t < tmax for the float t. The nearest t wins; equal t go to the lower global triangle index (meshes in order,
   triangles in order). Comparing pairs (t, index) makes the result independent of the order of the tests.

   Motion: at time weight b = local time in the segment, a = fl(1 - b), the vertex is fl(fl(a P0) + fl(b P1)) by
   component: one formula for all kernels, exact at the keys, the same for all triangles, monotone in P0 and P1.

   IN DOUBLES, with h = 2^-53, X and Y the largest |x|, |y| of the corners and Z that of |p_k d_k|. As |d_u| <= |d_k|,
   |p_u d_k| <= X + Z. Rounding p, two products and their difference, x is wrong by h (3 X + 4 Z), and so is y. Each of
   two products of these is wrong by X Ey + Y Ex + Ex Ey, and rounded, as is their difference: edge functions by less
   than

       B = 16 h X Y + 8 h Z (X + Y + 32 h Z)

   and beyond it has the exact sign; no value leaves the range of normal doubles. t, u and v are

       t = fl( ((U za + V zb) + W zc) (1 / (D d_k)) )      u = fl(V (d_k / (D d_k)))      v = fl(W (d_k / (D d_k)))

   where they are calm. V / D is wrong by 2 B / |D|: for B < 2^-25 |D|, and rounded to float, by 2^-23. With the range R
   of z, and B < 2^-6 |D|, the sum that t comes from is wrong by less than 5 B R: where that is 5 2^-29 of it, t is
   within 0.67 ulp. A normal is wrong by 6 h times the largest |p1 - p0| and |p2 - p0| by component: where
   that product is below 2^27 times it, by less than 2^-22 of its length.

   A hit that the filter below takes is calm by its depth's bounds lo and hi, if 5 (hi - lo) < hi. B of doubles is below h / eps =
   2^-29 of the filter's, b; that knows D for |D| > 4 b, where it is off by 3 b: B < 2^-28 |D|. The bounds are at least r =
   b R / |D| about their middle, so that lo > 8 r: z of the hit is above B R 2^29 / |D|, as that is b R / (|D| - 3 b) <= 4 r.
   A hit that doubles take leaves lo <= 0 where it is not calm.

   ELSE EXACTLY. Signs: where no step to x and y loses anything two products are compared, by what they lose too (Dekker's
   and Knuth's two-term products and sums), and so are those of a tie. That is so on a grid, as lattices are: if adding
   2^k M to numbers up to M and taking it away again leaves them as they are, they have at most f + 1 - k bits, f = 53 or
   24 being those of the format. Of coordinates with m bits and directions with n, differences have m + 1, x and y m + n + 2,
   no more than f. Kernels try it in floats (m = 18, n = 4) for eight lanes, then doubles (27, 24) for one; else what each
   step loses is looked at. All else is Shewchuk's expansions: differences of floats are sums of two doubles, the
   determinant a sum of 48 products of three, added up without any rounding; t, u, v and normals are their quotients.

   THE FILTER of kernels is the same in single precision, with S = fl(d_u / d_k) in place of d_u, d_k; eps = 2^-24,
   and z, Z without the factor d_k. It may fuse or not: results are the same, for what it leaves open is settled. Rounding
   p, S, their product and the difference makes x wrong by eps (2 X + 4 Z); an edge function, in products of these and
   their rounding, by eps (12 X Y + 8 Z (X + Y)) and terms of eps^2. Here

       B = 20.25 eps X Y + 8.25 eps Z (X + Y + 8 eps Z) + 2^-126

   is used, since the depth needs as much; the last is for what underflows. Where a product overflows so does B, and
   nothing is known. A triangle is dropped when some e < -B and some e > B, and hit when all are beyond B on one side.

   THE ESTIMATE of the depth w = s z of a hit, s = sign(d_k), takes the e, here u, v, w, as weights. Take the rounded
   corners first, and their exact edge functions, of sum D'. The plane over these is z = z' + g . (x, y); at the true
   weights, none of which is negative, the true x and y sum up to 0 and the rounded ones to their errors at most. So z' is
   wrong by |g_x| Ex + |g_y| Ey, and |g_x| <= 2 Y R / |D'|, since z - (the middle of its range) is at most R / 2 and the
   differences of y sum up to 4 Y: in all by R eps (8 X Y + 8 Z (X + Y)) / |D'|. Rounding then makes each e wrong by 2
   eps X Y, and eps |e|; two means that use such weights differ by (6 eps X Y + eps |D|) R / |D|. For |D| > 4 B, with
   a = eps X Y, |D| - |D'| is below 7 a, so that D for D' adds less than 2 a: 16 a and the 8 of Z, below B R / |D|.
   Evaluating the mean takes 4 roundings a weight, 3 for the sum and 1 for z, eps |D| above 2: 10 eps Z, one more to
   widen it. Two hits must be told apart in t, a float, which takes another 2 eps each. Hence bounds of

       B R / |D| + 16 eps Z + tiny

   about the estimate; for smaller |D|, or beyond FLT_MAX, they are infinite. Any hit needs no depth, only how it
   compares: all is multiplied by |D|, weights are not divided, and limits take another 2 roundings each: B R + (16 eps Z
   + tiny) |D| + 2^-126. Where this is below 2^100, |D| Z is below 2^121: no sum overflows, and a limit whose product
   with |D| does lies beyond all sums.

   With them a hit is dropped when it lies beyond what the ray still looks at, and taken when it is certain and lies
   wholly after tmin and before the nearest hit so far. All else is settled in doubles, on both triangles if need be. A
   taken hit leaves its bounds, not its t; that is computed once, for the hit that remains.

   BOXES must cover the triangle. Let M >= |P - o| for all vertices of the scene and all axes. Write G = d / |d_k|, w = s
   z = t |d_k|. At a crossing o + G w lies in the box. A slab distance is evaluated as plane * r - c, c = o r +- D |r|, r
   = fl(1 / G): r's own error scales plane - o: 1 eps M; slopes below 2^-26 raised to 2^-26: 1/4 eps M; o r, D |r| and
   c rounded: 3 eps |o|; plane * r, where the machine does not fuse: eps (|o| + M); the result: 1 eps M. Moving: a vertex
   is within 5/2 eps (|o| + M) of its place between the keys. A plane is evaluated as P0 + b fl(P1 - P0), where |P1 - P0|
   <= 2 M: 2 eps M for the difference, as much for the product where the machine does not fuse, eps (|o| + M) for the sum;
   as fl(a P0) + b P1 it is nearer to the vertex. Sum: below 11 eps M + 8 eps |o|. Frusta need more, below. We use D =
   eps (16 M + 8 |o|) + 2^-126, once per ray: no work in the loop. (The last term is for coordinates so small that
   rounding is absolute, by 2^-150 an operation.) Depth: a hit at w* <= wf must be visited when its t ties with the best
   t. t is within 0.7 ulp of w* / |d_k|, so w* <= t |d_k| (1 + 2^-23) + 2^-149 |d_k|; we use wf = t |d_k| (1 + 2^-22) +
   tiny, tiny = 2^-125 max(|d_k|, 1).

   FRUSTUM PACKETS work relative to a reference point, whose distance to the packet's origins is at most rho: C = o_uv -
   ref - G (s o_k - ref_w) is rounded by at most 5 eps rho; its value at the far depth by 2 eps (M + rho); the hull's
   evaluation by 3 eps (M + rho); plane - ref by eps (M + |o|); slopes by 5/4 eps M; moving nodes and corners as above,
   by 15/2 eps M + 7/2 eps |o|. The planes are moved outward by max D + 16 eps rho. Rays of one origin have o +- D in
   common, which is taken from the planes of a box before r multiplies: both differences are rounded by eps (|o| + M),
   less than c and plane * r.

   MOVING TRIANGLES of packets are filtered without the vertices that are defined: P0 + b fl(P1 - P0), as of planes
   above, is within 15/2 eps M + 7/2 eps |o| of these, and p, from which o is subtracted, within 17/2 eps M + 7/2 eps
   |o|. x and y, with twice that and 4 eps M of rounding, are within 3/2 pad of the exact ones, and so U is within 3 pad
   (X + Y + 3/2 pad) + 4 eps X Y. A ray is dropped when some e < -B and some e > B, B = 4 pad (X + Y + 2 pad) + 8 eps X Y
   + 2^-126. X here bounds |x| over the packet: where a triangle lies beyond all origins, what its corners are away from
   the planes and 4 pad more; else 2 M, of which 2 pad / (16 eps) is no less.

   INTERVALS of the paper path take (plane - o -+ D) r at the ends of the packet's intervals of o and r, with its
   largest D: a difference of extremes bounds the differences, and its three roundings cost less than a slab's. */

#ifndef PKTRT__SLACK /* the tests take parts of it away: hits are lost then, as they should be */
#define PKTRT__SLACK(part) 1.0f
#endif
#ifndef PKTRT__REACHED /* told when a triangle is tested in doubles (0), and when expansions decide (1) */
#define PKTRT__REACHED(stage) ((void)0)
#endif
#define PKTRT__EPS 5.9604644775390625e-8f /* 2^-24 */
#define PKTRT__PAD_M (PKTRT__SLACK(m) * 16 * PKTRT__EPS)
#define PKTRT__PAD_O (PKTRT__SLACK(o) * 8 * PKTRT__EPS)
#define PKTRT__PAD_MIN (PKTRT__SLACK(min) * FLT_MIN)
#define PKTRT__PAD_RHO (PKTRT__SLACK(rho) * 16 * PKTRT__EPS)
#define PKTRT__PAD_DEPTH (PKTRT__SLACK(depth) * 4 * PKTRT__EPS)
#define PKTRT__PAD_CROSS (PKTRT__SLACK(cross) * 20.25f * PKTRT__EPS)
#define PKTRT__PAD_SHEAR (PKTRT__SLACK(shear) * 8.25f * PKTRT__EPS)
#define PKTRT__PAD_SHEAR2 (8 * PKTRT__EPS)
#define PKTRT__PAD_MOVING (PKTRT__SLACK(moving) * 8 * PKTRT__EPS)
#define PKTRT__PAD_LEAST (PKTRT__SLACK(least) * FLT_MIN)
#define PKTRT__PAD_ESTIMATE (PKTRT__SLACK(estimate) * 16 * PKTRT__EPS)
#define PKTRT__PAD_TINY (PKTRT__SLACK(tiny) * 2 * FLT_MIN)
#define PKTRT__LEAST_DET (PKTRT__SLACK(det) * 4) /* times the error of an edge function */
#define PKTRT__MOST_ERROR 1.2676506e30f          /* 2^100 */
#define PKTRT__GRID_LEAST 9.094947e-13f          /* 2^-40 */
#define PKTRT__GRID_MOST 2.8823038e17f           /* 2^58 */
#define PKTRT__EPS2 1.1102230246251565e-16       /* 2^-53 */
#define PKTRT__CALM_DET 0.015625                 /* 2^-6 */
#define PKTRT__CALM_UV 2.9802322387695312e-8     /* 2^-25 */
#define PKTRT__CALM_T 1.862645149230957e-9       /* 2^-29 */
#define PKTRT__CALM_NORMAL 7.450580596923828e-9  /* 2^-27 */
#define PKTRT__CALM_DEPTH (PKTRT__SLACK(calm) * 5)
#define PKTRT__ERROR_T (1.4 * PKTRT__EPS)        /* of t */
#define PKTRT__ERROR_UV (2.0 * PKTRT__EPS)       /* of u and v */
#define PKTRT__ERROR_PLANE 3.552713678800501e-15 /* of planes, 2^-48 */
#define PKTRT__ERROR_LEAST 9.094947017729282e-13 /* at least, 2^-40 */
#define PKTRT__ERROR_NEEDLE 4.76837158203125e-7  /* of planes of needles, 2^-21 */

/* >>exact: the canonical test, and what it rests on ---------------------------------------------------------------- */

/* Each axis k with the next two, u and v, in cyclic order. */
static const uint32_t pktrt__axes[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};

/* A single ray with the values that a batch keeps in rows, which would lie on as many cache lines. */
typedef struct pktrt__single {
  PKTRT__ALIGN64 float rd[8], cn[8], cf[8]; /* by axis; the other lanes are unused */
  float there[8]; /* of a hit in an instance: the ray's origin, at 0, and direction, at 4, in the instance's frame */
  const pktrt_ray *ray;
  float slope[2], dk, wn, wf, sn, sf, tiny, pad, ta, tb;
  uint32_t id, slot, bvh, place, octant;
  uint32_t after;       /* at t = tmin triangles with a higher global index are hit; PKTRT_NONE: none are */
  const uint32_t *axis; /* k, u, v */
} pktrt__single;

/* Returns the motion segment of a time, and finds the weights of its two keys. */
PKTRT__INLINE uint32_t pktrt__time_segment(float time, uint32_t keys, float *a, float *b) {
  if (!(time > 0)) time = 0;
  if (time > 1) time = 1;
  if (keys < 2) { /* one key has all the weight */
    *a = 1, *b = 0;
    return 0;
  }
  const float f = time * (float)(keys - 1);
  uint32_t i = (uint32_t)f;
  if (i > keys - 2) i = keys - 2;
  *b = f - (float)i;
  *a = 1 - *b;
  return i;
}

PKTRT__INLINE double pktrt__max_abs3(double a, double b, double c) {
  return pktrt__max(fabs(a), pktrt__max(fabs(b), fabs(c)));
}

/* Computes cross(p1 - p0, p2 - p0); returns the product of the edges' largest coordinates. */
PKTRT__INLINE double pktrt__tri_normal_size(double p[3][3], double n[3]) {
  const double ax = p[1][0] - p[0][0], ay = p[1][1] - p[0][1], az = p[1][2] - p[0][2];
  const double bx = p[2][0] - p[0][0], by = p[2][1] - p[0][1], bz = p[2][2] - p[0][2];
  n[0] = ay * bz - az * by;
  n[1] = az * bx - ax * bz;
  n[2] = ax * by - ay * bx;
  return pktrt__max_abs3(ax, ay, az) * pktrt__max_abs3(bx, by, bz);
}
/* Tells whether its direction is as sharp as hits report it. */
PKTRT__INLINE bool pktrt__tri_normal_of(double p[3][3], double n[3]) {
  return pktrt__tri_normal_size(p, n) * PKTRT__CALM_NORMAL < pktrt__max_abs3(n[0], n[1], n[2]);
}
static bool pktrt__tri_normal(float p[3][3], double n[3]) {
  double q[3][3];
  for (int i = 0; i < 9; i++) q[i / 3][i % 3] = (double)p[i / 3][i % 3];
  return pktrt__tri_normal_of(q, n);
}

/* Computes the corners of a triangle at a ray's time; for work that is done once per ray, or seldom. */
static void pktrt__tri_corners_at(const pktrt__bvh *bvh, uint32_t slot, float time, float p[3][3]) {
  pktrt__block *block = pktrt__bvh_block(bvh, slot / 8);
  float a, b, *to = p[0];
  const uint32_t segment = pktrt__time_segment(time, bvh->key_count, &a, &b);
  const uint32_t next = pktrt__has_motion(bvh->key_count) ? segment + 1 : 0;
  const float *k0 = pktrt__block_vertices(block, segment) + slot % 8,
              *k1 = pktrt__block_vertices(block, next) + slot % 8;
  if (!pktrt__has_motion(bvh->key_count))
    for (int c = 0; c < 3; c++, k0 += 24) p[c][0] = k0[0], p[c][1] = k0[8], p[c][2] = k0[16];
  else
    for (int i = 0; i < 9; i++) to[i] = a * k0[8 * i] + b * k1[8 * i];
}

/* A triangle as a ray sees it, in doubles: corners, what they are away from its origin, its origin and direction; the ray's
   main axis first, then u and v. */
typedef struct pktrt__exact_view {
  double p[3][3], from_o[3][3], o[3], d[3];
} pktrt__exact_view;
/* `row` and `step`: how many floats the coordinates of the ray and of corners are apart. */
PKTRT__INLINE void pktrt__exact_see(pktrt__exact_view *v, int to, uint32_t axis, const float *o, const float *d,
                                    uint32_t row, const float *p, uint32_t step) {
  const double origin = v->o[to] = (double)o[row * axis];
  v->d[to] = (double)d[row * axis], p += step * axis;
  v->p[0][to] = (double)p[0], v->p[1][to] = (double)p[3 * step], v->p[2][to] = (double)p[6 * step];
  for (int c = 0; c < 3; c++) v->from_o[c][to] = v->p[c][to] - origin;
}
PKTRT__INLINE void pktrt__exact_view_of(pktrt__exact_view *v, const uint32_t *axis, const float *o, const float *d,
                                        uint32_t row, const float *p, uint32_t step) {
  pktrt__exact_see(v, 0, axis[0], o, d, row, p, step);
  pktrt__exact_see(v, 1, axis[1], o, d, row, p, step);
  pktrt__exact_see(v, 2, axis[2], o, d, row, p, step);
}
/* Of a triangle at the ray's time. WHY in place at rest: copies are read late. */
PKTRT__INLINE void pktrt__exact_view_at(pktrt__exact_view *v, const pktrt__bvh *bvh, uint32_t slot, float time,
                                        const uint32_t *axis, const float *o, const float *d, uint32_t row) {
  const bool moving = pktrt__has_motion(bvh->key_count);
  float copy[3][3];
  if (moving) pktrt__tri_corners_at(bvh, slot, time, copy);
  pktrt__exact_view_of(v, axis, o, d, row, moving ? copy[0] : &pktrt__bvh_block(bvh, slot / 8)->vertex[0][0][slot % 8],
                       moving ? 1 : 8);
}

typedef struct pktrt__exact_edges {
  double x[3], y[3];          /* of the corners */
  double u, v, w, det, depth; /* the edge functions, their sum, and their products with z, summed up */
  double error, range;        /* of each edge function; of z */
} pktrt__exact_edges;
PKTRT__INLINE pktrt__exact_edges pktrt__exact_edge_functions(const pktrt__exact_view *s) {
  const double k = s->d[0], u = s->d[1], v = s->d[2];
  const double az = s->from_o[0][0], ax = s->from_o[0][1] * k - u * az, ay = s->from_o[0][2] * k - v * az;
  const double bz = s->from_o[1][0], bx = s->from_o[1][1] * k - u * bz, by = s->from_o[1][2] * k - v * bz;
  const double cz = s->from_o[2][0], cx = s->from_o[2][1] * k - u * cz, cy = s->from_o[2][2] * k - v * cz;
  const double x = pktrt__max_abs3(ax, bx, cx), y = pktrt__max_abs3(ay, by, cy);
  const double z = pktrt__max_abs3(az, bz, cz) * fabs(k);
  pktrt__exact_edges e;
  e.x[0] = ax, e.x[1] = bx, e.x[2] = cx, e.y[0] = ay, e.y[1] = by, e.y[2] = cy;
  e.u = cx * by - cy * bx, e.v = ax * cy - ay * cx, e.w = bx * ay - by * ax;
  e.det = (e.u + e.v) + e.w, e.depth = (e.u * az + e.v * bz) + e.w * cz;
  e.error = (16 * PKTRT__EPS2 * x) * y + (8 * PKTRT__EPS2 * z) * ((x + y) + 32 * PKTRT__EPS2 * z);
  e.range = pktrt__max(az, pktrt__max(bz, cz)) - pktrt__min(az, pktrt__min(bz, cz));
  return e;
}
/* Tell whether doubles suffice for t, and for u and v. */
PKTRT__INLINE bool pktrt__exact_t_is_calm(const pktrt__exact_edges *e) {
  return e->error < fabs(e->det) * PKTRT__CALM_DET && e->error * e->range < fabs(e->depth) * PKTRT__CALM_T;
}
PKTRT__INLINE bool pktrt__exact_uv_is_calm(const pktrt__exact_edges *e) {
  return e->error < fabs(e->det) * PKTRT__CALM_UV;
}
PKTRT__INLINE bool pktrt__exact_is_calm(const pktrt__exact_edges *e) {
  return pktrt__exact_t_is_calm(e) && pktrt__exact_uv_is_calm(e);
}

/* Computes the last bits of a product, and of a difference, that rounding lost. */
PKTRT__INLINE double pktrt__tail_of_product(double a, double b, double product) {
  const double ca = a * 134217729.0, cb = b * 134217729.0; /* 2^27 + 1: Veltkamp's split */
  const double ah = ca - (ca - a), al = a - ah, bh = cb - (cb - b), bl = b - bh;
  return ((ah * bh - product) + ah * bl + al * bh) + al * bl;
}
PKTRT__INLINE double pktrt__tail_of_difference(double a, double b, double difference) {
  const double bb = a - difference, aa = difference + bb;
  return (a - aa) - (b - bb);
}

/* A sum without rounding (Shewchuk 1997): parts that do not overlap, the least first. */
typedef struct pktrt__exact_sum {
  double part[256];
  int n;
} pktrt__exact_sum;
static void pktrt__exact_add(pktrt__exact_sum *s, double x) {
  int n = 0;
  for (int i = 0; i < s->n; i++) {
    const double sum = x + s->part[i], low = pktrt__tail_of_difference(x, -s->part[i], sum);
    if (low != 0) s->part[n++] = low;
    x = sum;
  }
  if (x != 0) s->part[n++] = x;
  s->n = n;
}
static void pktrt__exact_add_product(pktrt__exact_sum *s, double a, double b) {
  const double product = a * b, low = pktrt__tail_of_product(a, b, product);
  if (low != 0) pktrt__exact_add(s, low);
  pktrt__exact_add(s, product);
}

/* A vector whose coordinates are sums of two doubles: of floats, or differences of floats. */
typedef struct pktrt__exact_vec {
  double at[3][2];
} pktrt__exact_vec;
static pktrt__exact_vec pktrt__exact_difference(const double *a, const double *b) {
  pktrt__exact_vec v;
  for (int i = 0; i < 3; i++) v.at[i][0] = a[i] - b[i], v.at[i][1] = pktrt__tail_of_difference(a[i], b[i], v.at[i][0]);
  return v;
}
static pktrt__exact_vec pktrt__exact_vec_of(const double *a) {
  static const double zero[3] = {0, 0, 0};
  return pktrt__exact_difference(a, zero);
}
/* Computes dot(a, cross(b, c)) without rounding but the last one, so that its sign is exact. No product of parts leaves
   the range of doubles, which are multiples of 2^-447. */
static double pktrt__exact_volume(const pktrt__exact_vec *a, const pktrt__exact_vec *b, const pktrt__exact_vec *c) {
  pktrt__exact_sum s;
  double sum = 0;
  PKTRT__REACHED(1);
  s.n = 0;
  for (uint32_t k = 0; k < 3; k++)
    for (uint32_t i = 0; i < 8; i++) { /* a_k (b_u c_v - b_v c_u), by parts */
      const uint32_t u = (k + 1) % 3, v = (k + 2) % 3;
      const double x = a->at[k][i & 1], y[2] = {b->at[u][i >> 1 & 1], -b->at[v][i >> 1 & 1]};
      const double z[2] = {c->at[v][i >> 2 & 1], c->at[u][i >> 2 & 1]};
      for (int j = 0; j < 2; j++) {
        const double product = x * y[j];
        if (product == 0 || z[j] == 0) continue;
        const double low = pktrt__tail_of_product(x, y[j], product);
        if (low != 0) pktrt__exact_add_product(&s, low, z[j]);
        pktrt__exact_add_product(&s, product, z[j]);
      }
    }
  for (int i = 0; i < s.n; i++) sum += s.part[i];
  return sum;
}

/* Returns the sign of a b - c d, exactly. */
static int pktrt__exact_compare(double a, double b, double c, double d) {
  const double x = a * b, y = c * d;
  if (x < y || x > y) return x < y ? -1 : 1;
  if (!(fabs(x) > 0)) return 0; /* no product of these underflows */
  const double low = pktrt__tail_of_product(a, b, x), other = pktrt__tail_of_product(c, d, y);
  return (low > other) - (low < other);
}

/* Tells whether coordinates and direction lie on grids of doubles so that no step to x, y and ties loses anything. */
static bool pktrt__exact_on_grid(const pktrt__exact_view *v) {
  double most = pktrt__max_abs3(v->o[0], v->o[1], v->o[2]), lost = 0;
  for (int c = 0; c < 3; c++) most = pktrt__max(most, pktrt__max_abs3(v->p[c][0], v->p[c][1], v->p[c][2]));
  const double coarse = most * 134217728.0, turn = fabs(v->d[0]) * 1073741824.0;
  for (int a = 0; a < 3; a++) {
    lost += fabs(v->o[a] - ((v->o[a] + coarse) - coarse)) + fabs(v->d[a] - ((v->d[a] + turn) - turn));
    for (int c = 0; c < 3; c++) lost += fabs(v->p[c][a] - ((v->p[c][a] + coarse) - coarse));
  }
  return !(lost > 0);
}

/* Tells whether no step to x and y of a corner loses anything. */
static bool pktrt__exact_corner_is_exact(const pktrt__exact_view *v, int c, double x, double y) {
  const double *p = v->from_o[c], *d = v->d, to[3] = {0, x, y};
  double lost = fabs(pktrt__tail_of_difference(v->p[c][0], v->o[0], p[0]));
  for (int i = 1; i < 3; i++) {
    const double a = p[i] * d[0], b = p[0] * d[i];
    lost += fabs(pktrt__tail_of_difference(v->p[c][i], v->o[i], p[i]));
    lost += fabs(pktrt__tail_of_product(p[i], d[0], a)) + fabs(pktrt__tail_of_product(p[0], d[i], b));
    lost += fabs(pktrt__tail_of_difference(a, b, to[i]));
  }
  return !(lost > 0);
}

/* Returns the sign of the edge function of corners p and r, which is d_k dot(d, cross(p, r)). Doubles have it where they
   have x and y exactly, as on grids seen along an axis, or where the ray passes a corner. */
PKTRT__NOINLINE int pktrt__exact_sign(const pktrt__exact_view *v, const pktrt__exact_edges *e, int p, int r) {
  for (int i = 1; i < 3; i++) /* in a plane along two axes */
    if (!(fabs(v->d[i]) + fabs(v->from_o[p][i]) + fabs(v->from_o[r][i]) > 0)) return 0;
  const bool one = pktrt__exact_corner_is_exact(v, p, e->x[p], e->y[p]);
  const bool other = pktrt__exact_corner_is_exact(v, r, e->x[r], e->y[r]);
  if ((one && e->x[p] == 0 && e->y[p] == 0) || (other && e->x[r] == 0 && e->y[r] == 0)) return 0;
  if (one && other) return pktrt__exact_compare(e->x[p], e->y[r], e->y[p], e->x[r]);
  const pktrt__exact_vec a = pktrt__exact_difference(v->p[p], v->o), b = pktrt__exact_difference(v->p[r], v->o);
  const pktrt__exact_vec d = pktrt__exact_vec_of(v->d);
  const double volume = pktrt__exact_volume(&d, &a, &b) * v->d[0];
  return (volume > 0) - (volume < 0);
}

/* Returns the sign of d_k dot(d, cross(q - p, a unit vector along axis a)); the other axes are b and c, in cyclic order. */
static int pktrt__exact_tie_sign(const double *d, const double *p, const double *q, uint32_t a) {
  const uint32_t b = (a + 1) % 3, c = (a + 2) % 3; /* d_b (q - p)_c - d_c (q - p)_b */
  const double x = q[b] - p[b], y = q[c] - p[c];
  if (pktrt__tail_of_difference(q[b], p[b], x) == 0 && pktrt__tail_of_difference(q[c], p[c], y) == 0)
    return pktrt__exact_compare(d[b], y, d[c], x) * (d[0] < 0 ? -1 : 1);
  const pktrt__exact_vec along = pktrt__exact_vec_of(d), edge = pktrt__exact_difference(q, p);
  pktrt__exact_vec unit;
  memset(&unit, 0, sizeof unit), unit.at[a][0] = 1;
  const double volume = pktrt__exact_volume(&along, &edge, &unit) * d[0];
  return (volume > 0) - (volume < 0);
}

/* Tell whether a ray crosses a triangle, if some edge functions are below 0 or above for certain: find the sign of each other,
   and of 0 that beside it, see >>exactness. On a grid products of directions and differences of corners are exact. */
PKTRT__INLINE double pktrt__exact_sign_on_grid(const pktrt__exact_view *v, const pktrt__exact_edges *e, double value,
                                               int p, int r) {
  const double *d = v->d, *from = v->p[p], *to = v->p[r];
  if (value < 0 || value > 0) return value;
  if (e->x[p] * e->y[r] != 0) value = pktrt__exact_compare(e->x[p], e->y[r], e->y[p], e->x[r]);
  if (!(value < 0 || value > 0)) value = d[0] * (d[2] * (to[0] - from[0]) - d[0] * (to[2] - from[2]));
  if (!(value < 0 || value > 0)) value = d[0] * (d[0] * (to[1] - from[1]) - d[1] * (to[0] - from[0]));
  return value;
}
PKTRT__NOINLINE bool pktrt__exact_decide(const pktrt__exact_view *v, const pktrt__exact_edges *e, bool below,
                                         bool above) {
  const double value[3] = {e->u, e->v, e->w};
  const bool on_grid = pktrt__exact_on_grid(v);
  for (int i = 0, p = 2, r = 1; i < 3 && !(below && above); r = p, p = i++) {
    if (fabs(value[i]) > e->error) continue;
    double sign = on_grid ? pktrt__exact_sign_on_grid(v, e, value[i], p, r) : pktrt__exact_sign(v, e, p, r);
    for (uint32_t a = 1; a < 3 && sign == 0 && !on_grid; a++) sign = pktrt__exact_tie_sign(v->d, v->p[p], v->p[r], a);
    if (!(sign < 0 || sign > 0)) return false; /* an edge along the ray */
    below = below || sign < 0, above = above || sign > 0;
  }
  return !(below && above);
}

static double pktrt__exact_quotient(double a, double b) { return a < 0 || a > 0 ? a / b : 0; } /* never -0 */

/* Computes t, u and v where doubles do not suffice. */
PKTRT__NOINLINE void pktrt__exact_solve(const pktrt__exact_view *v, float tuv[3]) {
  const pktrt__exact_vec e1 = pktrt__exact_difference(v->p[1], v->p[0]), e2 = pktrt__exact_difference(v->p[2], v->p[0]);
  const pktrt__exact_vec d = pktrt__exact_vec_of(v->d), a = pktrt__exact_difference(v->p[0], v->o);
  const double det = pktrt__exact_volume(&d, &e1, &e2);
  tuv[0] = pktrt__to_float(pktrt__exact_quotient(pktrt__exact_volume(&a, &e1, &e2), det));
  tuv[1] = (float)pktrt__exact_quotient(pktrt__exact_volume(&d, &e2, &a), det);
  tuv[2] = (float)pktrt__exact_quotient(pktrt__exact_volume(&d, &a, &e1), det);
}

/* Computes the volume of the ray's direction and two edges, without rounding but the last one. */
static double pktrt__exact_along(const pktrt__exact_view *v) {
  const pktrt__exact_vec e1 = pktrt__exact_difference(v->p[1], v->p[0]), e2 = pktrt__exact_difference(v->p[2], v->p[0]);
  const pktrt__exact_vec d = pktrt__exact_vec_of(v->d);
  return pktrt__exact_volume(&d, &e1, &e2);
}

/* Computes the normal, scaled to a largest component of 1. */
PKTRT__NOINLINE void pktrt__exact_normal(pktrt__exact_view v, double n[3]) {
  for (int a = 0; a < 3; a++) {
    for (int i = 0; i < 3; i++) v.d[i] = i == a;
    n[a] = pktrt__exact_along(&v);
  }
  const double most = pktrt__max_abs3(n[0], n[1], n[2]);
  for (int a = 0; a < 3 && most > 0; a++) n[a] /= most;
}

/* A crossing of a triangle: its t as doubles have it, and by how much the float of it may differ. */
typedef struct pktrt__exact_crossing {
  double t, error;
  bool calm;     /* the float nearest to t is the t of a hit */
  bool all_calm; /* and so are u and v */
} pktrt__exact_crossing;

/* Runs the canonical test of one triangle, but for the interval of t; tells whether it is crossed. */
PKTRT__DIVIDES_BY_ZERO PKTRT__NOINLINE bool pktrt__exact_cross(const pktrt__exact_view *v, pktrt__exact_crossing *c) {
  const pktrt__exact_edges e = pktrt__exact_edge_functions(v);
  const double least = pktrt__min(e.u, pktrt__min(e.v, e.w)), most = pktrt__max(e.u, pktrt__max(e.v, e.w));
  const bool below = least<-e.error, above = most> e.error;
  if (below && above) return false;
  if (!(least > e.error || most < -e.error) && !pktrt__exact_decide(v, &e, below, above)) return false;
  const double r = 1 / (e.det * v->d[0]), known = e.error < fabs(e.det) * PKTRT__CALM_DET ? 5 : INFINITY;
  c->t = e.depth * r, c->calm = pktrt__exact_t_is_calm(&e), c->all_calm = pktrt__exact_is_calm(&e);
  c->error = known * pktrt__max(e.error * e.range * fabs(r), DBL_MIN) + fabs(c->t) * PKTRT__PAD_DEPTH;
  return true;
}

/* Computes the t of a triangle that is crossed. */
static float pktrt__exact_t(const pktrt__exact_view *v, const pktrt__exact_crossing *c) {
  float tuv[3];
  if (c->calm) return pktrt__to_float(c->t);
  pktrt__exact_solve(v, tuv);
  return tuv[0];
}

/* >>batch ---------------------------------------------------------------------------------------------------------- */

enum {
  PKTRT__BATCH = 256,         /* rays handled together: a packet of the paper path, four of the fast path */
  PKTRT__FEW_OF_PACKET = 24,  /* rays that make no frustum: 16 to 24 of 64, slopes within 0.15 to 0.6, measured flat */
  PKTRT__FEW_OF_INSTANCE = 6, /* rays that go through an instance one by one: 4 to 8 measured flat */
  PKTRT__SPARE = 64,          /* of these lanes, those that instances need for rays in their frames, see >>places */
  PKTRT__ROW = PKTRT__BATCH + 16 /* a cache line more than a power of two, or all rows would share cache sets */
};

/* Rays, structure of arrays, with what the kernels derive from them. 37 KiB, on the stack of a query. */
typedef struct pktrt__batch {
  PKTRT__ALIGN64 float o[3][PKTRT__ROW];
  float d[3][PKTRT__ROW];
  float tmin[PKTRT__ROW], tmax[PKTRT__ROW], time[PKTRT__ROW];
  float t[PKTRT__ROW];        /* tmax; after resolving: t of the closest hit, if any */
  float slope[2][PKTRT__ROW]; /* Su, Sv of the canonical test */
  float dk[PKTRT__ROW];       /* d_k */
  float rd[3][PKTRT__ROW];    /* 1 / G, by axis */
  union {                     /* after traversal the hit replaces the values for slabs */
    struct {
      float cn[3][PKTRT__ROW]; /* o rd + D |rd|: near slab = plane rd - cn */
      float cf[3][PKTRT__ROW]; /* o rd - D |rd|: far slab = plane rd - cf */
    } slab;
    struct {
      float u[PKTRT__ROW], v[PKTRT__ROW], spare[PKTRT__ROW];
      float normal[3][PKTRT__ROW];
    } hit;
  } as;
  float wn[PKTRT__ROW], wf[PKTRT__ROW]; /* depths outside [wn, wf] cannot be the closest hit; see >>exactness */
  float sn[PKTRT__ROW], sf[PKTRT__ROW]; /* depths between these are certainly after tmin and nearer */
  float tiny[PKTRT__ROW];
  float pad[PKTRT__ROW];      /* D */
  float tb[PKTRT__ROW];       /* time weight b within the segment, for the BVH being traversed; a = 1 - b */
  uint32_t id[PKTRT__ROW];    /* global index of the closest hit's triangle; 0 at first: no tie with tmax is won.
                                    After resolving PKTRT_NONE where nothing is hit */
  uint32_t slot[PKTRT__ROW];  /* block * 8 + lane; PKTRT_NONE: no hit. For occlusion: 0 when occluded */
  uint32_t bvh[PKTRT__ROW];   /* of the closest hit */
  uint32_t place[PKTRT__ROW]; /* 1 more than the instance of the closest hit; 0: hit without one */
  uint8_t axis[PKTRT__ROW], octant[PKTRT__ROW];
  uint16_t segment[PKTRT__ROW];
  uint64_t valid[PKTRT__BATCH / 64];
  uint64_t moving[PKTRT__BATCH / 64]; /* rays of streams that may meet moving triangles, at any time */
  bool coherent;                      /* frustum packets took most of the last rays */
  const void *occluder_tree;          /* the blocks of the last leaf that hid rays of a frustum; NULL: none, at first */
  uint32_t occluder;                  /* its reference */
  uint32_t spare;                     /* the first lane of those that instances use */
} pktrt__batch;

/* Copies n rays, from lane `first` of a batch on, to lanes `at` and on of another; their intervals are not copied. */
PKTRT__INLINE void pktrt__batch_copy_rays(pktrt__batch *to, uint32_t at, const pktrt__batch *from, uint32_t first,
                                          uint32_t n) {
  const size_t size = n * sizeof(float);
  for (int a = 0; a < 3; a++)
    memcpy(to->o[a] + at, from->o[a] + first, size), memcpy(to->d[a] + at, from->d[a] + first, size);
  memcpy(to->time + at, from->time + first, size);
}
/* Copies the hits of n rays in the same way. */
PKTRT__INLINE void pktrt__batch_copy_hits(pktrt__batch *to, uint32_t at, const pktrt__batch *from, uint32_t first,
                                          uint32_t n) {
  const size_t size = n * sizeof(float);
  memcpy(to->id + at, from->id + first, size), memcpy(to->slot + at, from->slot + first, size);
  memcpy(to->bvh + at, from->bvh + first, size), memcpy(to->t + at, from->t + first, size);
  memcpy(to->place + at, from->place + first, size);
  memcpy(to->as.hit.u + at, from->as.hit.u + first, size), memcpy(to->as.hit.v + at, from->as.hit.v + first, size);
  for (int a = 0; a < 3; a++) memcpy(to->as.hit.normal[a] + at, from->as.hit.normal[a] + first, size);
}
/* Stores eight bytes, the lowest first. */
PKTRT__INLINE void pktrt__store_bytes(void *to, uint64_t bytes) {
#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
  for (uint32_t j = 0; j < 8; j++) PKTRT__CAST(uint8_t *, to)[j] = (uint8_t)(bytes >> 8 * j);
#else
  memcpy(to, &bytes, 8);
#endif
}

/* Fills the lanes behind the last ray with rays that hit nothing, up to a whole vector. */
static void pktrt__batch_pad(pktrt__batch *b, uint32_t n) {
  const uint32_t padded = (n + 15) / 16 * 16;
  for (uint32_t i = n; i < padded; i++) {
    for (int a = 0; a < 3; a++) b->o[a][i] = 0, b->d[a][i] = 0;
    b->tmin[i] = b->tmax[i] = b->time[i] = 0;
  }
}

/* Returns where the i-th ray of a batch stands among the caller's. */
PKTRT__INLINE size_t pktrt__batch_place(const uint16_t *order, size_t i) { return order ? order[i] : i; }

/* Loads the rays of a batch from lane i on, of n. */
static void pktrt__batch_load_rest(pktrt__batch *b, const pktrt_ray *rays, const uint16_t *order, uint32_t i,
                                   uint32_t n) {
  for (; i < n; i++) {
    const pktrt_ray *r = &rays[pktrt__batch_place(order, i)];
    for (int a = 0; a < 3; a++) b->o[a][i] = r->origin[a], b->d[a][i] = r->direction[a];
    b->tmin[i] = r->tmin, b->tmax[i] = r->tmax, b->time[i] = r->time;
  }
}

/* Returns the mesh of a global triangle index; tries the first mesh of its instance, *place - 1, before it searches. */
static uint32_t pktrt__mesh_search_from(const pktrt_scene *s, uint32_t id, const uint32_t *place) {
  const uint32_t first = pktrt__has_instances(s) && *place ? s->instances[*place - 1].first_mesh : 0;
  if (id - s->meshes[first].first_id < s->meshes[first].triangle_count) return first;
  const uint32_t *start = &s->starts[id >> s->start_shift];
  return start[0] + pktrt__mesh_search(s->meshes + start[0], start[1] - start[0] + 1, id);
}
/* Does so, but tries the last two answers first: neighbouring rays mostly hit these. */
PKTRT__INLINE uint32_t pktrt__mesh_lookup(const pktrt_scene *s, uint32_t id, const uint32_t *place, uint32_t hint[2]) {
  const pktrt__mesh *m = &s->meshes[hint[0]];
  if (id - m->first_id < m->triangle_count) return hint[0];
  const uint32_t other = hint[1];
  m = &s->meshes[other];
  hint[1] = hint[0];
  return hint[0] = id - m->first_id < m->triangle_count ? other : pktrt__mesh_search_from(s, id, place);
}

/* Finds mesh and triangle of a global index. */
PKTRT__INLINE void pktrt__mesh_name_triangle(const pktrt_scene *s, uint32_t id, const uint32_t *place, uint32_t hint[2],
                                             uint32_t *mesh, uint32_t *triangle) {
  *mesh = *triangle = PKTRT_NONE;
  if (id == PKTRT_NONE) return;
  *mesh = pktrt__mesh_lookup(s, id, place, hint);
  *triangle = id - s->meshes[*mesh].first_id;
}
static void pktrt__batch_store_rest(const pktrt_scene *s, const pktrt__batch *b, pktrt_hit *hits, const uint16_t *order,
                                    uint32_t i, uint32_t n) {
  uint32_t hint[2] = {0, 0};
  for (; i < n; i++) {
    pktrt_hit *h = &hits[pktrt__batch_place(order, i)];
    h->t = b->t[i], h->u = b->as.hit.u[i], h->v = b->as.hit.v[i];
    for (int a = 0; a < 3; a++) h->normal[a] = b->as.hit.normal[a][i];
    pktrt__mesh_name_triangle(s, b->id[i], b->place + i, hint, &h->mesh, &h->triangle);
  }
}

/* Tells whether n rays are too few for packets. WHY: so few gain nothing together, least of all where the first hit
   ends a ray. Eight shuffled shadow rays took 1.14 times as long in a stream as in single calls. */
PKTRT__INLINE bool pktrt__too_few(size_t n, bool occlusion) { return n < (occlusion ? 32u : 16u); }

static pktrt__bvh_segment pktrt__bvh_segment_of(const pktrt__bvh *bvhs, uint32_t index, uint32_t segment) {
  const pktrt__bvh *bvh = &bvhs[index];
  pktrt__bvh_segment v;
  v.bvhs = bvhs;
  v.nodes = bvh->nodes, v.blocks = bvh->blocks;
  v.node_bytes = bvh->node_bytes, v.block_bytes = bvh->block_bytes;
  const uint32_t next = pktrt__has_motion(bvh->key_count) ? segment + 1 : 0;
  v.plane0 = pktrt__node_key_offset(segment), v.plane1 = pktrt__node_key_offset(next);
  v.vertex0 = pktrt__block_key_offset(segment), v.vertex1 = pktrt__block_key_offset(next);
  v.bvh = index;
  return v;
}

/* Makes a triangle the closest hit of a ray, at a depth in [lo, hi]. */
PKTRT__INLINE void pktrt__batch_set_hit(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, float lo, float hi,
                                        uint32_t id, uint32_t slot) {
  b->sf[r] = lo, b->wf[r] = hi;
  b->id[r] = id, b->slot[r] = slot, b->bvh[r] = seg->bvh;
}
PKTRT__INLINE void pktrt__single_set_hit(const pktrt__bvh_segment *seg, pktrt__single *q, float lo, float hi,
                                         uint32_t id, uint32_t slot) {
  q->sf = lo, q->wf = hi;
  q->id = id, q->slot = slot, q->bvh = seg->bvh;
}

/* Computes the t of the closest hit so far. */
PKTRT__NOINLINE float pktrt__exact_t_of_hit(const pktrt__bvh *bvhs, const pktrt__single *q) {
  const pktrt_ray *ray = q->ray;
  pktrt__exact_crossing c = {0, 0, false, false};
  pktrt__exact_view v;
  pktrt__exact_view_at(&v, &bvhs[q->bvh], q->slot, ray->time, q->axis, ray->origin, ray->direction, 1);
  pktrt__exact_cross(&v, &c);
  return pktrt__exact_t(&v, &c);
}

/* Decides what bounds of depths leave open: whether a triangle that is crossed is hit in the ray's interval, and nearer
   than the closest hit so far, or as near with a lower index. Then its t is that float. */
PKTRT__NOINLINE bool pktrt__exact_is_nearer(const pktrt__bvh_segment *seg, const pktrt__single *q, uint32_t id,
                                            const pktrt__exact_view *v, pktrt__exact_crossing *c) {
  const float t = pktrt__exact_t(v, c);
  const pktrt_ray *ray = q->ray;
  float nearest = ray->tmax;
  if (!(ray->tmin < t || (t == ray->tmin && q->after < id))) return false;
  c->t = (double)t, c->error = fabs(c->t) * PKTRT__PAD_DEPTH;
  if (q->slot != PKTRT_NONE) nearest = pktrt__exact_t_of_hit(seg->bvhs, q);
  return t < nearest || (t == nearest && id < q->id);
}

/* Tells whether a ray meets the plane of a triangle at t < 0 (if that is before its interval) or t > tmax for certain: mostly
   that of a surface where it begins or ends, as near as arithmetic permits. t = f / g, f = n (P - o), g = n d, which err by less
   than 42 u of their bounds, and f - tmax g by 12 more. */
PKTRT__INLINE bool pktrt__exact_is_apart(pktrt__exact_view *v, float dk, bool starts, float tmax) {
  const double x = v->from_o[0][0], y = v->from_o[0][1], z = v->from_o[0][2];
  double n[3];
  const double size = pktrt__tri_normal_size(v->p, n) * (64 * PKTRT__EPS2), most = size * pktrt__max_abs3(x, y, z);
  double f = n[0] * x + n[1] * y + n[2] * z, g = n[0] * v->d[0] + n[1] * v->d[1] + n[2] * v->d[2];
  if (g < 0) f = -f, g = -g;
  const double wrong = size * fabs((double)dk), end = (double)tmax;
  return g > wrong && ((starts && f < -most) || f - end * g > most + fabs(end) * wrong);
}

/* Makes a triangle that is crossed the closest hit, if it is hit; true then. */
PKTRT__NOINLINE bool pktrt__exact_take(const pktrt__bvh_segment *seg, pktrt__single *q, uint32_t id, uint32_t slot,
                                       const pktrt__exact_view *v, pktrt__exact_crossing *c) {
  const double scale = fabs((double)q->dk), tiny = (double)q->tiny;
  double slack = c->error * scale + tiny, lo = c->t * scale - slack, hi = c->t * scale + slack;
  if (hi < (double)q->wn || (double)q->wf < lo) return false;
  if (!((double)q->sn < lo && hi < (double)q->sf)) { /* NaN too */
    if (!pktrt__exact_is_nearer(seg, q, id, v, c)) return false;
    slack = c->error * scale + tiny, lo = c->t * scale - slack, hi = c->t * scale + slack;
  }
  if (!c->all_calm) lo = pktrt__min(lo, 0);
  pktrt__single_set_hit(seg, q, (float)lo, (float)hi, id, slot);
  return true;
}

/* A packet of >>frustum. */
typedef struct pktrt__frustum {
  PKTRT__ALIGN64 float ow[64]; /* depth of the origin */
  float a[4], b[4];            /* planes a + b W: upper u, lower u, upper v, lower v */
  float slope[4];              /* bounds of the rays' slopes, in the same order */
  float apex[3], apex_pad;     /* where rays meet: u, v, k; and four times by what they may miss it */
  float ref[3];                /* reference point: u, v, depth */
  float sign, pad, far_, wmin, wmax;
  float depth; /* of the farthest origin */
  float tb[2]; /* weights b of the earliest and the latest ray */
  uint32_t k, ku, kv, octant;
  uint32_t base, first; /* lanes in the batch: the packet's first one, and that of its first ray */
  uint8_t list[64];     /* base + i: the packet's rays as streams list them */
  bool common;          /* all rays have one origin */
  bool pointed;         /* all nearly meet in the apex */
} pktrt__frustum;

/* Makes planes of the extremes that u and v have at W = 0 and at Y, upper and lower ones. Where rays end at Y, also bounds
   their slopes, and finds their apex there, which they miss by half their extent. */
PKTRT__NOINLINE void pktrt__frustum_bound(pktrt__frustum *f, float (*extreme)[4], bool ends) {
  f->pointed = ends || f->common, f->apex[2] = f->sign * (ends ? f->ref[2] + f->far_ : f->ref[2]);
  float miss = 0, most = fabsf(f->apex[2]);
  for (int a = 0; a < 2; a++) {
    const float upper = extreme[a][0], lower = extreme[a][1], top = extreme[a][2], bottom = extreme[a][3];
    f->a[2 * a] = upper, f->slope[2 * a] = f->b[2 * a] = (top - upper) / f->far_;
    f->a[2 * a + 1] = lower, f->slope[2 * a + 1] = f->b[2 * a + 1] = (bottom - lower) / f->far_;
    f->apex[a] = f->ref[a];
    if (!ends) continue;
    f->slope[2 * a] = (top - lower + 4 * f->pad) / f->far_;
    f->slope[2 * a + 1] = (bottom - upper - 4 * f->pad) / f->far_;
    f->apex[a] += 0.5f * (top + bottom), f->pointed = f->pointed && 32 * (top - bottom) < upper - lower;
    miss = pktrt__maxf(miss, 0.5f * (top - bottom)), most = pktrt__maxf(most, fabsf(f->apex[a]));
  }
  f->apex_pad = ends ? PKTRT__SLACK(apex) * (8 * (f->pad + miss) + 16 * PKTRT__EPS * most) : f->pad;
}

/* Notes whether frustum packets took most of the last n rays; returns how many they left. */
PKTRT__INLINE uint32_t pktrt__batch_note_coherence(pktrt__batch *b, const uint64_t *left, uint32_t n) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < PKTRT__BATCH / 64; i++) count += pktrt__popcount(left[i]);
  b->coherent = count <= n / 4;
  return count;
}

/* Copies a ray of a batch, and its closest hit so far, into a single ray. */
static void pktrt__single_from_batch(const pktrt__batch *b, uint32_t r, pktrt_ray *ray, pktrt__single *q) {
  for (int a = 0; a < 3; a++) {
    ray->origin[a] = b->o[a][r], ray->direction[a] = b->d[a][r];
    q->rd[a] = b->rd[a][r], q->cn[a] = b->as.slab.cn[a][r], q->cf[a] = b->as.slab.cf[a][r];
  }
  ray->tmin = b->tmin[r], ray->tmax = b->tmax[r], ray->time = b->time[r];
  q->ray = ray;
  q->slope[0] = b->slope[0][r], q->slope[1] = b->slope[1][r], q->dk = b->dk[r];
  q->wn = b->wn[r], q->wf = b->wf[r], q->sn = b->sn[r], q->sf = b->sf[r], q->tiny = b->tiny[r];
  q->pad = b->pad[r], q->tb = b->tb[r], q->ta = 1 - q->tb;
  q->id = b->id[r], q->slot = b->slot[r], q->bvh = b->bvh[r], q->octant = b->octant[r], q->after = PKTRT_NONE;
  q->place = b->place[r];
  q->axis = pktrt__axes[b->axis[r]];
}
PKTRT__INLINE void pktrt__single_to_batch(pktrt__batch *b, uint32_t r, const pktrt__single *q) {
  b->wf[r] = q->wf, b->sf[r] = q->sf, b->id[r] = q->id, b->slot[r] = q->slot, b->bvh[r] = q->bvh;
  b->place[r] = q->place;
}

/* Decide by the canonical test what single precision leaves open. WHY what is apart first, in a view of its own: most are,
   and values that nobody else reads stay in registers. */
PKTRT__NOINLINE bool pktrt__exact_test_rest(const pktrt__bvh_segment *seg, pktrt__single *q, uint32_t id,
                                            uint32_t slot) {
  const pktrt_ray *ray = q->ray;
  pktrt__exact_crossing c;
  pktrt__exact_view v;
  pktrt__exact_view_at(&v, &seg->bvhs[seg->bvh], slot, ray->time, q->axis, ray->origin, ray->direction, 1);
  return pktrt__exact_cross(&v, &c) && pktrt__exact_take(seg, q, id, slot, &v, &c);
}
PKTRT__NOINLINE bool pktrt__exact_test_rest_of(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t id,
                                               uint32_t slot) {
  pktrt_ray ray;
  pktrt__single q;
  pktrt__single_from_batch(b, r, &ray, &q);
  if (!pktrt__exact_test_rest(seg, &q, id, slot)) return false;
  pktrt__single_to_batch(b, r, &q);
  return true;
}
PKTRT__NOINLINE bool pktrt__exact_test(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t id,
                                       uint32_t slot) {
  pktrt__exact_view v;
  pktrt__exact_view_at(&v, &seg->bvhs[seg->bvh], slot, b->time[r], pktrt__axes[0], &b->o[0][r], &b->d[0][r],
                       PKTRT__ROW);
  return !pktrt__exact_is_apart(&v, b->dk[r], b->tmin[r] >= 0, b->tmax[r]) &&
         pktrt__exact_test_rest_of(seg, b, r, id, slot);
}
PKTRT__NOINLINE bool pktrt__exact_test_single(const pktrt__bvh_segment *seg, pktrt__single *q, uint32_t id,
                                              uint32_t slot) {
  const pktrt_ray *ray = q->ray;
  const bool starts = ray->tmin >= 0 && q->after == PKTRT_NONE; /* t = -0 may come after t = 0 */
  pktrt__exact_view v;
  PKTRT__REACHED(0);
  pktrt__exact_view_at(&v, &seg->bvhs[seg->bvh], slot, ray->time, pktrt__axes[0], ray->origin, ray->direction, 1);
  return !pktrt__exact_is_apart(&v, q->dk, starts, ray->tmax) && pktrt__exact_test_rest(seg, q, id, slot);
}

/* Compute t, u and v of a hit, and its normal, as in >>resolve; they return whether doubles suffice. */
PKTRT__DIVIDES_BY_ZERO PKTRT__INLINE bool pktrt__single_resolve_tuv(const pktrt__exact_view *v, float *t, float *u,
                                                                    float *w) {
  const pktrt__exact_edges e = pktrt__exact_edge_functions(v);
  const double r = 1 / (e.det * v->d[0]), rdet = v->d[0] * r;
  *t = pktrt__to_float(e.depth * r);
  *u = (float)(e.v * rdet), *w = (float)(e.w * rdet); /* at most 1 */
  return pktrt__exact_is_calm(&e);
}
PKTRT__DIVIDES_BY_ZERO PKTRT__INLINE bool pktrt__single_resolve_normal(pktrt__exact_view *v, const uint32_t *axis,
                                                                       float *normal, uint32_t row) {
  double n[3];
  const bool sharp = pktrt__tri_normal_of(v->p, n);
  const double unit = 1 / pktrt__max_abs3(n[0], n[1], n[2]);
  normal[row * axis[0]] = (float)(n[0] * unit), normal[row * axis[1]] = (float)(n[1] * unit);
  normal[row * axis[2]] = (float)(n[2] * unit);
  return sharp;
}
/* Computes them anew where doubles do not suffice for all. */
PKTRT__NOINLINE void pktrt__exact_resolve(pktrt__exact_view *v, const uint32_t *axis, float *t, float *u, float *w,
                                          float *normal, uint32_t row) {
  const pktrt__exact_edges e = pktrt__exact_edge_functions(v);
  const bool t_is_calm = pktrt__exact_t_is_calm(&e), uv_is_calm = pktrt__exact_uv_is_calm(&e);
  float tuv[3];
  double n[3];
  if (!(t_is_calm && uv_is_calm)) pktrt__exact_solve(v, tuv);
  if (!t_is_calm) *t = tuv[0];
  if (!uv_is_calm) *u = tuv[1], *w = tuv[2];
  if (pktrt__tri_normal_of(v->p, n)) return;
  pktrt__exact_normal(*v, n);
  for (int a = 0; a < 3; a++) normal[row * axis[a]] = (float)n[a];
}
/* In a view of its own: the values of one that nobody else reads stay in registers. */
PKTRT__COLD void pktrt__single_resolve_exactly(const pktrt_scene *s, const pktrt__single *q, pktrt_hit *hit) {
  const pktrt_ray *ray = q->ray;
  pktrt__exact_view v;
  pktrt__exact_view_at(&v, &s->bvhs[q->bvh], q->slot, ray->time, q->axis, ray->origin, ray->direction, 1);
  pktrt__exact_resolve(&v, q->axis, &hit->t, &hit->u, &hit->v, hit->normal, 1);
}
PKTRT__NOINLINE void pktrt__single_resolve(const pktrt_scene *s, const pktrt__single *q, pktrt_hit *hit) {
  const pktrt_ray *ray = q->ray;
  pktrt__exact_view v;
  pktrt__exact_view_at(&v, &s->bvhs[q->bvh], q->slot, ray->time, q->axis, ray->origin, ray->direction, 1);
  (void)pktrt__single_resolve_tuv(&v, &hit->t, &hit->u, &hit->v); /* bounds of its depth tell for less */
  const bool calm = (q->wf - q->sf) * PKTRT__CALM_DEPTH < q->wf,
             sharp = pktrt__single_resolve_normal(&v, q->axis, hit->normal, 1);
  if (!(calm && sharp)) pktrt__single_resolve_exactly(s, q, hit);
}
PKTRT__NOINLINE void pktrt__single_resolve_hits(const pktrt_scene *s, pktrt__batch *b, uint32_t i, uint32_t hits) {
  pktrt__exact_view v;
  bool sharp = false;
  for (uint32_t last = PKTRT_NONE, r; hits; hits &= hits - 1, last = r) {
    r = i + pktrt__lowest_bit(hits);
    const pktrt__bvh *bvh = &s->bvhs[b->bvh[r]];
    const uint32_t *axis = pktrt__axes[b->axis[r]];
    if (last != PKTRT_NONE && b->slot[r] == b->slot[last] && b->bvh[r] == b->bvh[last] && b->axis[r] == b->axis[last] &&
        b->o[0][r] == b->o[0][last] && b->o[1][r] == b->o[1][last] && b->o[2][r] == b->o[2][last] &&
        !pktrt__has_motion(bvh->key_count)) {
      for (int a = 0; a < 3; a++) v.d[a] = (double)b->d[axis[a]][r], b->as.hit.normal[a][r] = b->as.hit.normal[a][last];
    } else {
      pktrt__exact_view_at(&v, bvh, b->slot[r], b->time[r], axis, &b->o[0][r], &b->d[0][r], PKTRT__ROW);
      sharp = pktrt__single_resolve_normal(&v, axis, &b->as.hit.normal[0][r], PKTRT__ROW);
    }
    if (!(pktrt__single_resolve_tuv(&v, &b->t[r], &b->as.hit.u[r], &b->as.hit.v[r]) && sharp))
      pktrt__exact_resolve(&v, axis, &b->t[r], &b->as.hit.u[r], &b->as.hit.v[r], &b->as.hit.normal[0][r], PKTRT__ROW);
  }
}

/* >>places: how instances lie, and rays in their frames ------------------------------------------------------------

   DEFINITION. At a ray's time, with the weights a and b of >>exactness, an instance has the matrix (A s) = a (A0 s0) + b (A1
   s1), in doubles, and the inverse R, the adjugate of A times 1 / det A. In its frame a ray (o, d) is the ray

       o' = fl( R (o - s) )      d' = fl( R d )

   each a sum of three products in doubles, from left to right, rounded to float at the end, or of one where A is diagonal
   at all keys (zeros would lose signs, and nothing would be as it is without an instance); its t is that of the scene's
   ray, for nothing is normalised. One ray serves all triangles of the instance: these are hit as >>exactness has it, their
   exactness and all that follows from it included. Where the largest |d'| is below 2^-100 or above 2^100, or o' leaves the
   range of origins, the ray misses. Normals are cross products of the edges A e.

   BOXES of instances must hold what such rays hit. A hit at p = o' + t d' is seen at o + t d, which is A p + s but for A
   (e_o + t e_d), |e_o| <= eps |o'|, |e_d| <= eps |d'|. As t |d'| <= |p| + |o'|, that is at most eps |A| (2 |o'| + |p|), and
   |o'| <= |R| |o - s|, where |o - s| <= M + mu, mu = |A| m, m the largest |p| of the model: below

       eps (2 kappa (M + mu) + mu)      kappa: the largest sum of a row of |A| |R|

   mu's part widens the box, by 3 for 2 to pay for doubles; M's part is in D, which is `stretch` times what >>exactness
   asks for: 16 stretch >= 11 + 3 kappa. kappa does not depend on the length of columns; between two keys, with columns of
   at most 1 and det A >= c, the least of its Bernstein coefficients, it is at most 18 / c. */

#define PKTRT__PLACE_LEAST 7.888609052210118e-31 /* 2^-100 */
#define PKTRT__PLACE_FLAT 9.313225746154785e-10  /* 2^-30: of a determinant, for columns of length 1 */

/* Tells whether the matrices of an instance have diagonals only. */
static bool pktrt__place_is_straight(const float *keys, uint32_t key_count) {
  bool straight = true;
  for (uint32_t i = 0; i < 12 * key_count; i++) straight = straight && (i % 12 % 5 == 0 || i % 4 == 3 || keys[i] == 0);
  return straight;
}

/* Compute how an instance lies between two keys: its matrix, and then its inverse. */
PKTRT__INLINE void pktrt__place_mix(const float *k0, const float *k1, float ta, float tb, bool straight,
                                    pktrt__place *p) {
  for (int i = 0; i < 3; i++, k0 += 4, k1 += 4) {
    for (int j = 0; j < 3; j++) p->a[i][j] = (double)ta * (double)k0[j] + (double)tb * (double)k1[j];
    p->shift[i] = (double)ta * (double)k0[3] + (double)tb * (double)k1[3];
  }
  p->straight = straight;
}
PKTRT__NOINLINE void pktrt__place_invert(pktrt__place *p) {
  double adjugate[3][3];
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      const double *u = p->a[(i + 1) % 3], *v = p->a[(i + 2) % 3];
      adjugate[j][i] = u[(j + 1) % 3] * v[(j + 2) % 3] - u[(j + 2) % 3] * v[(j + 1) % 3];
    }
  const double det = (p->a[0][0] * adjugate[0][0] + p->a[0][1] * adjugate[1][0]) + p->a[0][2] * adjugate[2][0];
  const double r = 1 / det;
  memset(p->inverse, 0, sizeof p->inverse), p->shift[3] = 0;
  for (int i = 0; i < 9; i++) p->inverse[i % 3][i / 3] = adjugate[i / 3][i % 3] * r;
  for (int i = 0; i < 3; i++) p->inverse[3][i] = p->inverse[i][i];
}

/* Return how an instance lies at a time, in *moving if it moves: its matrix, and all. */
PKTRT__INLINE const pktrt__place *pktrt__place_matrix_at(const pktrt__instance *in, float time, pktrt__place *moving) {
  float ta, tb;
  if (!pktrt__has_motion(in->key_count)) return &in->rest;
  const float *key = in->keys + 12 * (size_t)pktrt__time_segment(time, in->key_count, &ta, &tb);
  pktrt__place_mix(key, key + 12, ta, tb, in->rest.straight, moving);
  return moving;
}
PKTRT__INLINE const pktrt__place *pktrt__place_at(const pktrt__instance *in, float time, pktrt__place *moving) {
  const pktrt__place *place = pktrt__place_matrix_at(in, time, moving);
  if (place == moving) pktrt__place_invert(moving);
  return place;
}

/* Returns -1 where an instance is mirrored, else 1. */
static int pktrt__place_side(const pktrt__place *p) {
  const double *x = p->a[0], *y = p->a[1], *z = p->a[2];
  return x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]) <
                 0
             ? -1
             : 1;
}

/* Multiply a vector by a matrix, which may have a diagonal only: by that of an instance, and its inverse. */
PKTRT__INLINE void pktrt__place_turn(const pktrt__place *p, const double x[3], double out[3]) {
  const double(*m)[3] = p->a;
  if (p->straight) out[0] = m[0][0] * x[0], out[1] = m[1][1] * x[1], out[2] = m[2][2] * x[2];
  else
    for (int i = 0; i < 3; i++) out[i] = (m[i][0] * x[0] + m[i][1] * x[1]) + m[i][2] * x[2];
}
PKTRT__INLINE void pktrt__place_turn_back(const pktrt__place *p, const double x[3], double out[3]) {
  const double(*m)[4] = p->inverse;
  if (p->straight) out[0] = m[3][0] * x[0], out[1] = m[3][1] * x[1], out[2] = m[3][2] * x[2];
  else
    for (int i = 0; i < 3; i++) out[i] = (m[0][i] * x[0] + m[1][i] * x[1]) + m[2][i] * x[2];
}

/* Computes a ray in the frame of an instance; `row` and `to_row`: how many floats coordinates are apart. */
PKTRT__NOINLINE void pktrt__place_ray(const pktrt__place *p, const float *o, const float *d, size_t row, float *to_o,
                                      float *to_d, size_t to_row) {
  double x[3], along[3], there[3], way[3];
  for (size_t i = 0; i < 3; i++) x[i] = (double)o[i * row] - p->shift[i], along[i] = (double)d[i * row];
  pktrt__place_turn_back(p, x, there), pktrt__place_turn_back(p, along, way);
  for (size_t i = 0; i < 3; i++)
    to_o[i * to_row] = pktrt__to_float(there[i]), to_d[i * to_row] = pktrt__to_float(way[i]);
  const double most = pktrt__max_abs3(way[0], way[1], way[2]);
  if (!(most >= PKTRT__PLACE_LEAST && most <= 1 / PKTRT__PLACE_LEAST)) to_d[0] = to_d[to_row] = to_d[2 * to_row] = 0;
}

#ifndef PKTRT__NO_TOP
/* Returns a tmax for a ray in an instance, which leaves what ties with the closest hit so far, at depths up to wf. */
PKTRT__INLINE float pktrt__place_tmax(uint32_t slot, float wf, float dk, float tmax) {
  return slot == PKTRT_NONE ? tmax : pktrt__minf(wf / fabsf(dk), tmax);
}

/* Returns the lane of the nearest of some. */
PKTRT__INLINE uint32_t pktrt__place_nearest(uint32_t lanes, const float dist[8]) {
  uint32_t c = pktrt__lowest_bit(lanes);
  for (uint32_t m = lanes & (lanes - 1); m; m &= m - 1)
    if (dist[pktrt__lowest_bit(m)] < dist[c]) c = pktrt__lowest_bit(m);
  return c;
}

/* Tells whether what a tree of the top level is above are trees of the scene. */
PKTRT__INLINE bool pktrt__place_is_group(const pktrt_scene *scene, const pktrt__bvh_segment *seg) {
  return PKTRT__GROUPS && scene->groups && seg->bvhs == scene->groups->bvhs;
}

/* Copies rays of a batch, those in mask of a list, to its spare lanes; returns how many. */
static uint32_t pktrt__place_copy_rays(pktrt__batch *b, const uint8_t *list, uint64_t mask, bool closest) {
  uint32_t n = b->spare;
  for (; mask; mask &= mask - 1, n++) {
    const uint32_t r = list[pktrt__lowest_bit(mask)];
    for (int a = 0; a < 3; a++) b->o[a][n] = b->o[a][r], b->d[a][n] = b->d[a][r];
    b->tmin[n] = b->tmin[r], b->time[n] = b->time[r];
    b->tmax[n] = closest ? pktrt__place_tmax(b->slot[r], b->wf[r], b->dk[r], b->tmax[r]) : b->tmax[r];
  }
  pktrt__batch_pad(b, n);
  return n - b->spare;
}
/* Moves rays [begin, end) of a batch to the frame of an instance. */
static void pktrt__place_move_rays(const pktrt__instance *in, pktrt__batch *b, uint32_t begin, uint32_t end) {
  for (uint32_t r = begin; r < end; r++) {
    pktrt__place moving;
    const pktrt__place *p = pktrt__place_at(in, b->time[r], &moving);
    pktrt__place_ray(p, &b->o[0][r], &b->d[0][r], PKTRT__ROW, &b->o[0][r], &b->d[0][r], PKTRT__ROW);
  }
}

/* Sees the triangle of a hit in an instance as its ray does; `there`: that ray, as pktrt__single has it, or NULL. */
PKTRT__INLINE const pktrt__place *pktrt__place_view(const pktrt__instance *in, uint32_t bvh, uint32_t slot,
                                                    const pktrt_ray *ray, const float *there, pktrt__exact_view *v,
                                                    pktrt__place *moving, const uint32_t **axis) {
  const pktrt__place *p =
      there ? pktrt__place_matrix_at(in, ray->time, moving) : pktrt__place_at(in, ray->time, moving);
  float turned[8];
  if (!there) pktrt__place_ray(p, ray->origin, ray->direction, 1, turned, turned + 4, 1), there = turned;
  const float *o = there, *d = there + 4;
  const bool not_x = fabsf(d[0]) < fabsf(d[1]) || fabsf(d[0]) < fabsf(d[2]);
  *axis = pktrt__axes[!not_x ? 0 : fabsf(d[1]) < fabsf(d[2]) ? 2 : 1];
  pktrt__exact_view_at(v, &in->model->bvhs[bvh], slot, ray->time, *axis, o, d, 1);
  return p;
}

/* A hit in an instance: its triangle, and bounds of its depth as the scene's ray has it, of those within. Two roundings of
   these are less than what is added, which also keeps t apart. */
typedef struct pktrt__place_hit {
  float lo, hi;
  uint32_t place, id, slot, bvh;
} pktrt__place_hit;
PKTRT__INLINE void pktrt__place_hit_bounds(pktrt__place_hit *h, float lo, float hi, float dk_within, float dk,
                                           float tiny) {
  const float unit = fabsf(dk), from = pktrt__minf(lo / fabsf(dk_within), FLT_MAX) * unit,
              to = hi / fabsf(dk_within) * unit;
  h->lo = from - (fabsf(from) * PKTRT__PAD_DEPTH + tiny), h->hi = to + (fabsf(to) * PKTRT__PAD_DEPTH + tiny);
}
/* Computes the t of a hit in an instance. */
static float pktrt__place_t(const pktrt_scene *s, uint32_t place, uint32_t bvh, uint32_t slot, const pktrt_ray *ray) {
  const uint32_t *axis;
  pktrt__exact_view v;
  pktrt__exact_crossing c = {0, 0, false, false};
  pktrt__place moving;
  (void)pktrt__place_view(&s->instances[place - 1], bvh, slot, ray, NULL, &v, &moving, &axis);
  pktrt__exact_cross(&v, &c);
  return pktrt__exact_t(&v, &c);
}
/* Decides what bounds of depths leave open: whether a hit in an instance is nearer than the closest hit of a ray so far,
   or as near with a lower index. */
PKTRT__NOINLINE bool pktrt__place_is_nearer(const pktrt_scene *s, const pktrt__single *q, const pktrt__place_hit *h) {
  const float t = pktrt__place_t(s, h->place, h->bvh, h->slot, q->ray);
  const float nearest =
      q->place ? pktrt__place_t(s, q->place, q->bvh, q->slot, q->ray) : pktrt__exact_t_of_hit(s->bvhs, q);
  return t < nearest || (t == nearest && h->id < q->id);
}

/* Takes over what the spare lanes have found, for the rays in mask of a list; returns those that are hit, or nearer. */
static uint64_t pktrt__place_take(const pktrt_scene *s, uint32_t index, pktrt__batch *b, const uint8_t *list,
                                  uint64_t mask, bool closest) {
  uint64_t hit = 0;
  for (uint32_t j = b->spare; mask; mask &= mask - 1, j++) {
    const uint32_t r = list[pktrt__lowest_bit(mask)];
    if (b->slot[j] == PKTRT_NONE) continue;
    if (closest) {
      pktrt__place_hit h = {0, 0, index + 1, s->instances[index].first_id + b->id[j], b->slot[j], b->bvh[j]};
      pktrt__place_hit_bounds(&h, b->sf[j], b->wf[j], b->dk[j], b->dk[r], b->tiny[r]);
      if (b->slot[r] != PKTRT_NONE && !(h.hi < b->sf[r])) {
        pktrt_ray ray;
        pktrt__single q;
        if (b->wf[r] < h.lo) continue;
        pktrt__single_from_batch(b, r, &ray, &q);
        if (!pktrt__place_is_nearer(s, &q, &h)) continue;
      }
      b->sf[r] = h.lo, b->wf[r] = h.hi, b->id[r] = h.id, b->slot[r] = h.slot, b->bvh[r] = h.bvh, b->place[r] = h.place;
    }
    hit |= mask & (0u - mask);
  }
  return hit;
}

/* Computes t, u, v and normal of a hit in an instance. */
static void pktrt__place_resolve(const pktrt_scene *s, uint32_t place, uint32_t bvh, uint32_t slot,
                                 const pktrt_ray *ray, const float *there, pktrt_hit *hit) {
  const uint32_t *axis;
  pktrt__exact_view v;
  pktrt__place moving;
  const pktrt__place *p = pktrt__place_view(&s->instances[place - 1], bvh, slot, ray, there, &v, &moving, &axis);
  double edge[3][3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, n[3], exact[3];
  if (!pktrt__single_resolve_tuv(&v, &hit->t, &hit->u, &hit->v))
    pktrt__exact_resolve(&v, axis, &hit->t, &hit->u, &hit->v, hit->normal, 1);
  for (int c = 1; c < 3; c++) {
    double e[3];
    for (int a = 0; a < 3; a++) e[axis[a]] = v.p[c][a] - v.p[0][a];
    pktrt__place_turn(p, e, edge[c]);
  }
  if (!pktrt__tri_normal_of(edge, n)) { /* by the cofactors of A */
    pktrt__exact_normal(v, exact);
    for (int i = 0; i < 3; i++) {
      const double *x = p->a[(i + 1) % 3], *y = p->a[(i + 2) % 3];
      n[i] = 0;
      for (int a = 0; a < 3; a++) {
        const uint32_t j = axis[a], k = (j + 1) % 3, l = (j + 2) % 3;
        n[i] += (x[k] * y[l] - x[l] * y[k]) * exact[a];
      }
    }
  }
  const double unit = 1 / pktrt__max_abs3(n[0], n[1], n[2]);
  for (int a = 0; a < 3; a++) hit->normal[a] = (float)(n[a] * unit);
}
/* Does so for the rays i to i+7 of a batch in `hits`. */
PKTRT__NOINLINE void pktrt__place_resolve_hits(const pktrt_scene *s, pktrt__batch *b, uint32_t i, uint32_t hits) {
  for (; hits; hits &= hits - 1) {
    const uint32_t r = i + pktrt__lowest_bit(hits);
    pktrt_ray ray;
    pktrt_hit hit;
    for (int a = 0; a < 3; a++) ray.origin[a] = b->o[a][r], ray.direction[a] = b->d[a][r];
    ray.time = b->time[r], ray.tmin = ray.tmax = 0;
    pktrt__place_resolve(s, b->place[r], b->bvh[r], b->slot[r], &ray, NULL, &hit);
    b->t[r] = hit.t, b->as.hit.u[r] = hit.u, b->as.hit.v[r] = hit.v;
    for (int a = 0; a < 3; a++) b->as.hit.normal[a][r] = hit.normal[a];
  }
}

#endif

/* Prefetches a child that will be visited. Measured worth 5% of a stream's time, and of a single ray's. */
PKTRT__INLINE void pktrt__bvh_prefetch(const pktrt__bvh_segment *seg, uint32_t ref, const bool moving) {
  const size_t node_bytes = moving ? seg->node_bytes : (size_t)PKTRT__NODE_BYTES;
  const size_t block_bytes = moving ? seg->block_bytes : (size_t)PKTRT__BLOCK_BYTES;
  const bool leaf = (ref & PKTRT__LEAF) != 0;
  const unsigned char *at = leaf ? seg->blocks + (ref & ~PKTRT__LEAF) * block_bytes : seg->nodes + ref * node_bytes;
  PKTRT__PREFETCH(at);
  PKTRT__PREFETCH(at + 64);
  PKTRT__PREFETCH(at + 128);
  PKTRT__PREFETCH(at + 192);
  PKTRT__PREFETCH(at + 256); /* in vain for a node at rest, but without a branch */
  for (size_t i = 320; moving && i < (leaf ? block_bytes : node_bytes); i += 64) PKTRT__PREFETCH(at + i);
}

/* Prefetches the caller's values. */
PKTRT__INLINE void pktrt__prefetch_lines(const void *at, size_t bytes) {
  for (size_t i = 0; i < bytes; i += 64) PKTRT__PREFETCH((const unsigned char *)at + i);
}

#define PKTRT__IN_ORDER 076543210u /* a perm that leaves children in their order */

/* Returns the halves of a ray mask that has one bit: its high one first, its low one 32 further on. WHY a table: vectors
   are broadcast from memory faster than from a register. */
PKTRT__INLINE const uint32_t *pktrt__mask_halves(uint32_t bit) {
#define PKTRT__BITS4(i) UINT32_C(1) << (i), UINT32_C(2) << (i), UINT32_C(4) << (i), UINT32_C(8) << (i)
#define PKTRT__BITS16(i) PKTRT__BITS4(i), PKTRT__BITS4(i + 4), PKTRT__BITS4(i + 8), PKTRT__BITS4(i + 12)
#define PKTRT__ZERO16 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0
  static const uint32_t halves[96] = {PKTRT__ZERO16, PKTRT__ZERO16, PKTRT__BITS16(0), PKTRT__BITS16(16)};
  return halves + bit;
#undef PKTRT__ZERO16
#undef PKTRT__BITS16
#undef PKTRT__BITS4
}

/* Pushes the children with a non-empty ray mask in the order of perm, without branches; returns how many. */
PKTRT__INLINE uint32_t pktrt__stream_push_children(const uint64_t *mask, const uint32_t *child, const float *dist,
                                                   uint32_t perm, uint64_t *masks, uint32_t *refs, float *dists) {
  uint32_t n = 0;
  for (int i = 0; i < 8; i++, perm >>= 3) {
    const uint32_t c = perm & 7;
    masks[n] = mask[c], refs[n] = child[c], dists[n] = dist[c];
    n += mask[c] != 0;
  }
  return n;
}

#ifndef PKTRT_NO_RENDER
/* >>random: what samples are made of ------------------------------------------------------------------------------- */

/* Returns the key of a seed, a pixel (or tile of pixels) and a group of dimensions, from which everything random comes:
   pktrt__hash of the key plus a small number gives 64 bits for each use of it. Seed and group are mixed before the
   pixel joins, so that no seed gives the shifted picture of another. */
PKTRT__INLINE uint64_t pktrt__sampler_key(uint32_t seed, uint32_t group, uint32_t x, uint32_t y) {
  const uint64_t pixel = ((uint64_t)y << 32 | x) * UINT64_C(0xD1342543DE82EF95);
  return pktrt__hash(pixel + pktrt__hash((uint64_t)seed << 32 | group));
}

/* Returns the upper 24 of 32 bits as a number in [0,1), as many as a float holds, so that none is rounded up to 1. */
PKTRT__INLINE float pktrt__sampler_unit(uint32_t bits) { return (float)(int32_t)(bits >> 8) * (1.0f / 16777216); }
PKTRT__INLINE float pktrt__sampler_unit_of(double x) {
  return (float)(int32_t)(x * 16777216) * (1.0f / 16777216);
} /* [0,1) */
PKTRT__INLINE uint32_t pktrt__sampler_below(uint32_t bits, uint32_t n) { return (uint32_t)((uint64_t)bits * n >> 32); }

/* Reverses the order of bits. */
PKTRT__INLINE uint32_t pktrt__reverse_bits(uint32_t x) {
  x = (x >> 1 & 0x55555555u) | (x & 0x55555555u) << 1;
  x = (x >> 2 & 0x33333333u) | (x & 0x33333333u) << 2;
  x = (x >> 4 & 0x0F0F0F0Fu) | (x & 0x0F0F0F0Fu) << 4;
#if defined(__GNUC__) || defined(__clang__)
  return __builtin_bswap32(x);
#else
  x = (x >> 8 & 0x00FF00FFu) | (x & 0x00FF00FFu) << 8;
  return x >> 16 | x << 16;
#endif
}

/* Scrambles a number whose bits are in reverse order as Owen (1995) does, by arithmetic (Laine and Karras 2011, Burley
   2020; constants by Vegdahl 2021): nothing carries towards lower bits, so that each bit is flipped by a hash of those
   below it and of the key. The sum makes the result uniform over keys. */
PKTRT__INLINE uint32_t pktrt__sampler_owen(uint32_t x, uint32_t key) {
  x ^= x * 0x3D20ADEAu;
  x += key;
  x *= key >> 16 | 1;
  x ^= x * 0x05526C56u;
  return x ^ x * 0x53A22864u;
}

#if defined(__GNUC__) || defined(__clang__)
PKTRT__INLINE uint32_t pktrt__bit_width(uint32_t x) { return x ? 32 - (uint32_t)__builtin_clz(x) : 0; } /* in bits */
#else
PKTRT__INLINE uint32_t pktrt__bit_width(uint32_t x) {
  uint32_t n = 0;
  for (; x; x >>= 1) n++;
  return n;
}
#endif

/* Applies a bijection of the next power of two: odd factors carry randomness up, shifts down. */
PKTRT__INLINE uint32_t pktrt__sampler_permute_round(uint32_t i, uint32_t ones, uint32_t shift, uint32_t key) {
  i = (i * (key | 1) + (key >> 16)) & ones;
  i ^= i >> shift;
  i = (i ^ i * (key >> 8 & ~1u)) & ones;
  return i ^ i >> 1;
}
PKTRT__INLINE uint32_t pktrt__sampler_permute_rounds(uint32_t i, uint32_t ones, uint32_t shift, uint64_t key) {
  i = pktrt__sampler_permute_round(i, ones, shift, (uint32_t)key);
  i = pktrt__sampler_permute_round(i, ones, shift, (uint32_t)(key >> 32));
  return pktrt__sampler_permute_round(i, ones, shift, (uint32_t)(key >> 16));
}
PKTRT__INLINE uint32_t pktrt__sampler_rotate(uint32_t i, uint32_t n, uint64_t key) {
  i += pktrt__sampler_below((uint32_t)key * 0x9E3779B9u + (uint32_t)(key >> 32), n);
  return i < n ? i : i - n;
}

/* Returns element i < n of a random permutation of n numbers, n <= 2^31, for a key that is mixed already. Rounds are
   repeated until the number is below n again (Kensler 2013); a rotation makes every place equally likely. */
PKTRT__INLINE uint32_t pktrt__sampler_permute(uint32_t i, uint32_t n, uint64_t key) {
  const uint32_t width = pktrt__bit_width(n - 1), ones = (1u << width) - 1, shift = (width + 1) / 2;
  do i = pktrt__sampler_permute_rounds(i, ones, shift, key);
  while (i >= n);
  return pktrt__sampler_rotate(i, n, key);
}

/* Multiplies x by Pascal's matrix, the second of Sobol's dimensions: bit k of the result is the sum modulo 2 of the
   bits j of x for which the binomial (j over k) is odd, that is, k is a subset of j in binary. */
PKTRT__INLINE uint32_t pktrt__sampler_pascal(uint32_t x) {
  x ^= x >> 1 & 0x55555555u;
  x ^= x >> 2 & 0x33333333u;
  x ^= x >> 4 & 0x0F0F0F0Fu;
  x ^= x >> 8 & 0x00FF00FFu;
  return x ^ x >> 16;
}

/* Sobol's points (1967): the radical inverse, Pascal's matrix, and his third dimension, by direction numbers 1, 3,
   whose bits stand here lowest digit first. Any 2^k points from a multiple of 2^k on are even: t = 0 in 2D, 1 in 3D. */
static const uint16_t pktrt__sampler_third[16] = {0x1,   0x3,   0x6,   0x9,   0x17,   0x3A,   0x71,   0xA3,
                                                  0x116, 0x339, 0x677, 0x9AA, 0x1601, 0x3903, 0x7706, 0xAA09};

/* Returns the binary digits of i / n, the first in the lowest bit. */
PKTRT__INLINE uint32_t pktrt__sampler_digits(uint32_t i, uint32_t n) {
  return pktrt__reverse_bits((uint32_t)(((uint64_t)i << 32) / n));
}

/* Computes the digits, lowest bit first, of the four coordinates of point i of n. Where the number of points is known,
   i / n comes for nothing as one more dimension; it is the third here. Of 2^k points t is 0 in dimensions 0 to 2, in
   pairs 0, 1 and 2, 3, and in most others, and 1 in all four. Hardly any set that is scrambled in Owen's way does
   better: 4 to 256 points err within 1.5% of the least that any such set can, on products of exp(a x) and on boxes (a
   bound by linear programming, see bench/error/README.md). */
PKTRT__INLINE void pktrt__sampler_net(uint32_t i, uint32_t n, uint32_t x[4]) {
  x[0] = i, x[1] = pktrt__sampler_pascal(i), x[2] = pktrt__sampler_digits(i, n), x[3] = 0;
  for (uint32_t k = 0; k < 16; k++) x[3] ^= i >> k & 1 ? pktrt__sampler_third[k] : 0;
}

/* Returns the index whose first two coordinates are the third and fourth of point `index` of a sequence, for sets that
   continue each other. Sobol's first two dimensions are a (0,2)-sequence: every 2^m points from a multiple of 2^m on
   have one in each elementary interval of area 2^-m. So are the third and the fourth here: the first two once more, of
   the index times a matrix (upper triangular with ones on its diagonal: such 2^m indices stay together). The matrix was
   found by search over such matrices, for the exact variance of a smooth model integrand; all four dimensions have t =
   1 for 4 and 16 points, 2 for up to 512, and then up to 4. Sobol's own four (numbers by Joe and Kuo 2008) err as much,
   but his third and fourth alone are no (0,2)-sequence. Tables for four columns at a time. */
PKTRT__INLINE uint32_t pktrt__sampler_second_pair(uint32_t index) {
  static const uint32_t sums[8][16] = {
      {0x0, 0x1, 0x3, 0x2, 0x7, 0x6, 0x4, 0x5, 0xE, 0xF, 0xD, 0xC, 0x9, 0x8, 0xA, 0xB},
      {0x0, 0x12, 0x31, 0x23, 0x62, 0x70, 0x53, 0x41, 0xE7, 0xF5, 0xD6, 0xC4, 0x85, 0x97, 0xB4, 0xA6},
      {0x0, 0x103, 0x21D, 0x31E, 0x76C, 0x66F, 0x571, 0x472, 0x966, 0x865, 0xB7B, 0xA78, 0xE0A, 0xF09, 0xC17, 0xD14},
      {0x0, 0x112B, 0x2336, 0x321D, 0x7BB5, 0x6A9E, 0x5883, 0x49A8, 0xC12E, 0xD005, 0xE218, 0xF333, 0xBA9B, 0xABB0,
       0x99AD, 0x8886},
      {0x0, 0x1B937, 0x3925D, 0x22B6A, 0x6BEB7, 0x70780, 0x52CEA, 0x495DD, 0x95FA5, 0x8E692, 0xACDF8, 0xB74CF, 0xFE112,
       0xE5825, 0xC734F, 0xDCA78},
      {0x0, 0x15C4E6, 0x3449E0, 0x218D06, 0x5C1244, 0x49D6A2, 0x685BA4, 0x7D9F42, 0xE46750, 0xF1A3B6, 0xD02EB0,
       0xC5EA56, 0xB87514, 0xADB1F2, 0x8C3CF4, 0x99F812},
      {0x0, 0x1727BC7, 0x3C1633D, 0x2B318FA, 0x6171B22, 0x76560E5, 0x5D6781F, 0x4A403D8, 0xCAC3369, 0xDDE48AE,
       0xF6D5054, 0xE1F2B93, 0xABB284B, 0xBC9538C, 0x97A4B76, 0x80830B1},
      {0x0, 0x170C1663, 0x3FAB3E5C, 0x28A7283F, 0x6E869CD2, 0x798A8AB1, 0x512DA28E, 0x4621B4ED, 0xAB80B177, 0xBC8CA714,
       0x942B8F2B, 0x83279948, 0xC5062DA5, 0xD20A3BC6, 0xFAAD13F9, 0xEDA1059A}};
  uint32_t x = sums[0][index & 15] ^ sums[1][index >> 4 & 15] ^ sums[2][index >> 8 & 15] ^ sums[3][index >> 12 & 15];
  if (index >> 16)
    x ^= sums[4][index >> 16 & 15] ^ sums[5][index >> 20 & 15] ^ sums[6][index >> 24 & 15] ^ sums[7][index >> 28];
  return x;
}

PKTRT__INLINE void pktrt__sampler_sequence(uint32_t index, uint32_t x[4]) {
  x[0] = index, x[2] = pktrt__sampler_second_pair(index);
  x[1] = pktrt__sampler_pascal(x[0]), x[3] = pktrt__sampler_pascal(x[2]);
}

/* Returns which point of a net a sample takes: in random order, so that groups of dimensions meet at random. The first
   group, the camera's, need not move for that. */
PKTRT__INLINE uint32_t pktrt__sampler_point_index(uint32_t group, uint32_t sample, uint32_t samples, uint64_t key) {
  return group ? pktrt__sampler_permute(sample, samples, key) : sample;
}

/* Scrambles coordinates first to first + n - 1, of four, of a point whose digits are x. */
PKTRT__INLINE void pktrt__sampler_scramble(const uint32_t x[4], uint64_t key, uint32_t first, uint32_t n, float *out) {
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t d = first + i;
    const uint64_t keys = pktrt__hash(key + (d & 2));
    out[i] = pktrt__sampler_unit(pktrt__reverse_bits(pktrt__sampler_owen(x[d], (uint32_t)(d & 1 ? keys : keys >> 32))));
  }
}

/* Returns which point of the sequence a sample of a run takes. A run starts at a multiple of the next power of two
   above the number of samples; it is a net by itself, and with its neighbours a larger one. Samples come in random
   order, so that groups of dimensions meet at random. (Shuffled in Owen's way, each beginning of a run would be spread
   as well as the whole, but two groups together would err up to sqrt(2) times as much.) */
PKTRT__INLINE uint32_t pktrt__sampler_run_index(uint32_t run, uint32_t sample, uint32_t samples, uint64_t order) {
  return (run << pktrt__bit_width(samples - 1)) + pktrt__sampler_permute(sample, samples, order);
}

/* >>kinds: materials, lights and samplers, a row for each ---------------------------------------------------------- */

/* Each table is an X-macro, in the order of its enumeration, which is checked; see >>extend. */

/* Kinds of specular materials: the feature that it needs; whether it has no diffuse base; whether it can have a lobe;
   and whether its reflectance is what it takes from the albedo: 0 is none then, and both together are at most 1. For
   others reflectance is a tint, and 0 in all channels means 1. */
#define PKTRT__SPECULAR_ROWS(ROW)                               \
  ROW(NONE, 0, false, false, false)                             \
  ROW(MIRROR, PKTRT_FEATURE_MIRROR, false, true, true)          \
  ROW(COAT, PKTRT_FEATURE_MIRROR, false, true, false)           \
  ROW(DIELECTRIC, PKTRT_FEATURE_DIELECTRIC, true, false, false) \
  ROW(CONDUCTOR, PKTRT_FEATURE_CONDUCTOR, true, true, false)
#define PKTRT__SPECULAR_ROW(id, feature, bare, lobes, takes) {feature, bare, lobes, takes},
#define PKTRT__SPECULAR_PLACE(id, feature, bare, lobes, takes) PKTRT__SPECULAR_ROW_##id,
#define PKTRT__SPECULAR_CHECK(id, feature, bare, lobes, takes) \
  PKTRT__STATIC_ASSERT(row_of_specular_##id, (int)PKTRT__SPECULAR_ROW_##id == (int)PKTRT_SPECULAR_##id);
enum { PKTRT__SPECULAR_ROWS(PKTRT__SPECULAR_PLACE) PKTRT__SPECULAR_ROW_COUNT };
PKTRT__SPECULAR_ROWS(PKTRT__SPECULAR_CHECK)
PKTRT__STATIC_ASSERT(each_specular_has_a_row, (int)PKTRT__SPECULAR_ROW_COUNT == (int)PKTRT_SPECULAR_COUNT);
static const struct pktrt__specular_row {
  uint32_t feature;
  bool bare, lobes, takes;
} pktrt__specular_rows[PKTRT_SPECULAR_COUNT] = {PKTRT__SPECULAR_ROWS(PKTRT__SPECULAR_ROW)};

/* Kinds of lights: traits, what finds out where one is and how large, and what takes a point of it. */
typedef enum pktrt__light_trait {
  PKTRT__LIGHT_PLACED = 1,      /* `position` counts */
  PKTRT__LIGHT_DIRECTED = 2,    /* `direction` counts */
  PKTRT__LIGHT_EDGED = 4,       /* `edge` counts */
  PKTRT__LIGHT_ROUND = 8,       /* `radius` counts */
  PKTRT__LIGHT_AREA = 16,       /* DRT samples it */
  PKTRT__LIGHT_INFINITE = 32,   /* its points are directions */
  PKTRT__LIGHT_EMISSIVE = 64,   /* `mesh` counts, and its emission */
  PKTRT__LIGHT_FLAT = 128,      /* seen as its middle it counts by area and cosine, on the side of `facing` */
  PKTRT__LIGHT_HIT = 256,       /* rays hit it by themselves */
  PKTRT__LIGHT_EACH = 512,      /* it is sampled, for u = NULL, where nothing is random, too: its middle will not do */
  PKTRT__LIGHT_BY_SQUARE = 1024 /* as its middle it counts by the square of the distance, which `sample` leaves out */
} pktrt__light_trait;
typedef struct pktrt__light_data pktrt__light_data;
typedef struct pktrt__render_state pktrt__render_state;
/* Fills in, of middle, radius, area and facing, which are 0, what traits and sample ask for. false: out of memory. */
typedef bool pktrt__light_prepare(const pktrt__render_state *, const pktrt_light *, pktrt__light_data *);
/* Where a light is looked at from. */
typedef struct pktrt__light_view {
  double point[3], normal[3]; /* the normal that shading uses, of unit length */
  float time;
} pktrt__light_view;
/* Takes a point `at` of a light, for u in [0,1)^2 (NULL: its middle). Returns the irradiance of a surface that faces it,
   for radiance or intensity 1; for lights with extent that is one over the density of the point, by solid angle. */
typedef double pktrt__light_sample(const pktrt__render_state *, uint32_t light, const float u[2],
                                   const pktrt__light_view *, double at[3]);
/* Finds the point `at` of a light in a direction of unit length. Returns one over the density that it is sampled with;
   0: there is none. */
typedef double pktrt__light_meet(const pktrt__render_state *, uint32_t light, const pktrt__light_view *,
                                 const double direction[3], double at[3]);
static pktrt__light_prepare pktrt__light_prepare_place, pktrt__light_prepare_direction, pktrt__light_prepare_quad,
    pktrt__light_prepare_mesh;
static pktrt__light_sample pktrt__light_sample_middle, pktrt__light_sample_quad, pktrt__light_sample_sphere,
    pktrt__light_sample_mesh, pktrt__light_sample_environment;
static pktrt__light_meet pktrt__light_meet_quad, pktrt__light_meet_sphere;
#define PKTRT__LIGHT_UNMET \
  PKTRT__CAST(pktrt__light_meet *, 0) /* lobes do not look for it: their rays find it, or nothing can */
#define PKTRT__LIGHT_ROWS(ROW)                                                                                         \
  ROW(POINT, PKTRT__LIGHT_PLACED | PKTRT__LIGHT_BY_SQUARE, pktrt__light_prepare_place, pktrt__light_sample_middle,     \
      PKTRT__LIGHT_UNMET)                                                                                              \
  ROW(DIRECTIONAL, PKTRT__LIGHT_DIRECTED | PKTRT__LIGHT_INFINITE, pktrt__light_prepare_direction,                      \
      pktrt__light_sample_middle, PKTRT__LIGHT_UNMET)                                                                  \
  ROW(QUAD, PKTRT__LIGHT_PLACED | PKTRT__LIGHT_EDGED | PKTRT__LIGHT_AREA | PKTRT__LIGHT_FLAT | PKTRT__LIGHT_BY_SQUARE, \
      pktrt__light_prepare_quad, pktrt__light_sample_quad, pktrt__light_meet_quad)                                     \
  ROW(SPHERE, PKTRT__LIGHT_PLACED | PKTRT__LIGHT_ROUND | PKTRT__LIGHT_AREA | PKTRT__LIGHT_EACH,                        \
      pktrt__light_prepare_place, pktrt__light_sample_sphere, pktrt__light_meet_sphere)                                \
  ROW(MESH, PKTRT__LIGHT_EMISSIVE | PKTRT__LIGHT_AREA | PKTRT__LIGHT_HIT, pktrt__light_prepare_mesh,                   \
      pktrt__light_sample_mesh, PKTRT__LIGHT_UNMET)                                                                    \
  ROW(ENVIRONMENT, PKTRT__LIGHT_AREA | PKTRT__LIGHT_INFINITE | PKTRT__LIGHT_HIT | PKTRT__LIGHT_EACH,                   \
      pktrt__light_prepare_place, pktrt__light_sample_environment, PKTRT__LIGHT_UNMET)
#define PKTRT__LIGHT_ROW(id, traits, prepare, sample, meet)                                            \
  {traits, PKTRT__AREA_LIGHTS || !((traits)&PKTRT__LIGHT_AREA) ? prepare : pktrt__light_prepare_place, \
   PKTRT__AREA_LIGHTS || !((traits)&PKTRT__LIGHT_AREA) ? sample : pktrt__light_sample_middle,          \
   PKTRT__AREA_LIGHTS ? meet : PKTRT__LIGHT_UNMET},
#define PKTRT__LIGHT_PLACE(id, traits, prepare, sample, meet) PKTRT__LIGHT_ROW_##id,
#define PKTRT__LIGHT_CHECK(id, traits, prepare, sample, meet) \
  PKTRT__STATIC_ASSERT(row_of_light_##id, (int)PKTRT__LIGHT_ROW_##id == (int)PKTRT_LIGHT_##id);
enum { PKTRT__LIGHT_ROWS(PKTRT__LIGHT_PLACE) PKTRT__LIGHT_ROW_COUNT };
PKTRT__LIGHT_ROWS(PKTRT__LIGHT_CHECK)
PKTRT__STATIC_ASSERT(each_light_has_a_row, (int)PKTRT__LIGHT_ROW_COUNT == (int)PKTRT_LIGHT_KIND_COUNT);
typedef struct pktrt__light_row {
  uint32_t traits;
  pktrt__light_prepare *prepare;
  pktrt__light_sample *sample;
  pktrt__light_meet *meet;
} pktrt__light_row;
PKTRT__COLD void pktrt__environment_free(const pktrt_scene_desc *, struct pktrt__environment *);
static const pktrt__light_row pktrt__light_rows[PKTRT_LIGHT_KIND_COUNT] = {PKTRT__LIGHT_ROWS(PKTRT__LIGHT_ROW)};
PKTRT__INLINE bool pktrt__light_has(const pktrt_light *l, uint32_t traits) {
  return (pktrt__light_rows[l->kind].traits & traits) != 0;
}

/* Samplers: name, what draws PKTRT__DRAWN of it at a time (pktrt__sampler_draw of the kernels), if any, and what gives the coordinates of one group: dimension / 4
   is the same for all n. `samples` is in range, `sample` below it. */
typedef void pktrt__sampler_group(const pktrt_sampling *, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                  uint32_t n, float *out);
static pktrt__sampler_group pktrt__sampler_sobol, pktrt__sampler_random, pktrt__sampler_jittered,
    pktrt__sampler_interleaved, pktrt__sampler_halton, pktrt__sampler_blue_noise;
typedef enum pktrt__drawn { PKTRT__DRAWN_SINGLY, PKTRT__DRAWN_SOBOL, PKTRT__DRAWN_RANDOM } pktrt__drawn;
#define PKTRT__SAMPLER_ROWS(ROW)                                                   \
  ROW(SOBOL, "sobol", PKTRT__DRAWN_SOBOL, pktrt__sampler_sobol)                    \
  ROW(RANDOM, "random", PKTRT__DRAWN_RANDOM, pktrt__sampler_random)                \
  ROW(JITTERED, "jittered", PKTRT__DRAWN_SINGLY, pktrt__sampler_jittered)          \
  ROW(INTERLEAVED, "interleaved", PKTRT__DRAWN_SINGLY, pktrt__sampler_interleaved) \
  ROW(HALTON, "halton", PKTRT__DRAWN_SINGLY, pktrt__sampler_halton)                \
  ROW(HAMMERSLEY, "hammersley", PKTRT__DRAWN_SINGLY, pktrt__sampler_halton)        \
  ROW(BLUE_NOISE, "blue-noise", PKTRT__DRAWN_SINGLY, pktrt__sampler_blue_noise)
#define PKTRT__SAMPLER_ROW(id, name, drawn, group) {name, drawn, group},
#define PKTRT__SAMPLER_PLACE(id, name, drawn, group) PKTRT__SAMPLER_ROW_##id,
#define PKTRT__SAMPLER_CHECK(id, name, drawn, group) \
  PKTRT__STATIC_ASSERT(row_of_sampler_##id, (int)PKTRT__SAMPLER_ROW_##id == (int)PKTRT_SAMPLER_##id);
enum { PKTRT__SAMPLER_ROWS(PKTRT__SAMPLER_PLACE) PKTRT__SAMPLER_ROW_COUNT };
PKTRT__SAMPLER_ROWS(PKTRT__SAMPLER_CHECK)
PKTRT__STATIC_ASSERT(each_sampler_has_a_row, (int)PKTRT__SAMPLER_ROW_COUNT == (int)PKTRT_SAMPLER_COUNT);
static const struct pktrt__sampler_row {
  const char *name;
  pktrt__drawn drawn;
  pktrt__sampler_group *group;
} pktrt__sampler_rows[PKTRT_SAMPLER_COUNT] = {PKTRT__SAMPLER_ROWS(PKTRT__SAMPLER_ROW)};

/* >>waves ---------------------------------------------------------------------------------------------------------- */

/* A render works on waves: a batch of rays of one generation, traced in place, and what a path carries along. Their hits
   become a dense list of surfaces, whose shadow rays fill a list, and whose reflected and refracted rays fill the waves of the next
   generation. All this is working space from the allocate hook, allocated where a generation is first needed. */
typedef struct pktrt__wave {
  pktrt__batch rays;             /* and their hits. WHY not 512 or 1024: gained nothing, and did not fit the caches */
  float radiance[3][PKTRT__ROW]; /* the result: the radiance that arrives along the ray */
  float weight[3][PKTRT__ROW];   /* of this radiance at the surface that sent the ray */
  float importance[PKTRT__ROW];  /* of this radiance in the sample: product of the largest weights on the way */
  uint32_t parent[PKTRT__ROW];   /* lane of the wave that sent the ray */
  uint32_t medium[PKTRT__ROW];   /* the glasses that the ray is in, see >>media; 0: none */
  uint32_t key[PKTRT__ROW];      /* which sample dimensions its scattering events use */
  uint32_t material[PKTRT__ROW]; /* of the surface that sent the ray, for assembly */
  uint32_t root[PKTRT__ROW];     /* the primary ray it descends from */
  uint32_t end[PKTRT__ROW];      /* where the packet ends that begins with this ray */
  /* Of the ray of a lobe, with gloss: the density of its direction, 0 where lights do not share what it finds; and how
     much the environment counts for it. */
  float density[PKTRT__ROW], sky[PKTRT__ROW];
} pktrt__wave;

/* The surfaces that the rays of a wave hit, without gaps for rays that hit nothing. Rows are as long as a batch's. */
typedef struct pktrt__surfaces {
  PKTRT__ALIGN64 double point[3][PKTRT__ROW];
  float position[3][PKTRT__ROW]; /* the same, for hooks */
  float ng[3][PKTRT__ROW];       /* unit geometric normal towards the viewer */
  float ns[3][PKTRT__ROW];       /* unit shading normal on the same side */
  float nf[3][PKTRT__ROW];       /* the normal that scattering uses: ns, or ng where ns looks away */
  float d[3][PKTRT__ROW];        /* unit direction of the ray */
  float mirror[3][PKTRT__ROW], refracted[3][PKTRT__ROW]; /* unit directions, above and below ng */
  float fresnel[PKTRT__ROW], eta[PKTRT__ROW];            /* eta: index behind the surface over the one before it */
  float offset[PKTRT__ROW];                              /* how far rays start from the surface, see >>spawn */
  float start[3][PKTRT__ROW];                            /* origin of the rays that leave on the side of ng */
  float distance[PKTRT__ROW];
  float albedo[3][PKTRT__ROW], reflectance[3][PKTRT__ROW], emission[3][PKTRT__ROW];
  float reflected[3][PKTRT__ROW];   /* weight of the reflected ray */
  float transmitted[3][PKTRT__ROW]; /* weight of the refracted ray */
  float radiance[3][PKTRT__ROW];
  float lobe[3][PKTRT__ROW];                 /* with gloss: the unit direction drawn from a lobe */
  float density[PKTRT__ROW];                 /* and its density; 0: it points below the surface, or there is no lobe */
  float shared[PKTRT__ROW], sky[PKTRT__ROW]; /* as density and sky of a wave */
  uint32_t ray[PKTRT__ROW];                  /* lane in the wave */
  uint32_t number[PKTRT__ROW];               /* 0, 1, 2, ...: lists of some of the surfaces are packed from these */
  uint32_t material[PKTRT__ROW], mesh[PKTRT__ROW], triangle[PKTRT__ROW];
  /* bit k % 8 of entry k / 8: */
  uint8_t inside[PKTRT__BATCH / 8];   /* the ray came from where corners appear clockwise */
  uint8_t shaded[PKTRT__BATCH / 8];   /* shaded completely by a shader hook */
  uint8_t hooked[PKTRT__BATCH / 8];   /* has a texture or a shader */
  uint8_t lobed[PKTRT__BATCH / 8];    /* reflects in a lobe */
  uint8_t bare[PKTRT__BATCH / 8];     /* has no diffuse base */
  uint8_t followed[PKTRT__BATCH / 8]; /* rays of its lobe are, and share the light of what they find */
  uint8_t lit[PKTRT__BATCH / 8]; /* lights can add to it: not to glass, polished metal and what is shaded already */
  uint8_t kind[PKTRT_SPECULAR_COUNT][PKTRT__BATCH / 8]; /* by pktrt_specular */
  uint32_t first; /* where their rays begin in the wave, packed: see pktrt__surface_gather */
  uint32_t count;
} pktrt__surfaces;

enum { PKTRT__DRAWN = 64 }; /* draws at once. WHY: sixteen took half as long again, waiting for each other's products */
typedef struct pktrt__sample_batch { /* a batch of draws: whose sample numbers, and results; see pktrt_sample */
  PKTRT__ALIGN64 uint32_t x[PKTRT__ROW];
  uint32_t y[PKTRT__ROW], sample[PKTRT__ROW];
  uint32_t group[PKTRT__ROW]; /* first group of four dimensions of the event; callers add the same to all */
  uint32_t count;             /* rounded up to PKTRT__DRAWN by zeros */
  float u[4][PKTRT__ROW];
} pktrt__sample_batch;

typedef struct pktrt__light_samples {        /* the points of one light that shadow rays go to, for each surface */
  PKTRT__ALIGN64 double at[3][PKTRT__BATCH]; /* a point; a direction if the light is infinitely far */
  double factor[PKTRT__BATCH];               /* irradiance of a surface that faces it, for radiance or intensity 1 */
  float arriving[3][PKTRT__BATCH];           /* radiance or intensity */
  float shared
      [PKTRT__BATCH]; /* lobes share the light between both ways: 1 / strength; 0: samples alone count; -1: rays alone */
} pktrt__light_samples;

typedef struct pktrt__light_target {  /* one light as the target of shadow rays */
  const pktrt__light_samples *listed; /* a sample for each surface; NULL: the fields below hold for all */
  bool flat, emissive;                /* as the traits say */
  double at[3], radius;               /* a point of it, or a direction; mesh: middle and radius of a sphere around it */
  double facing[3]; /* quad: unit normal; mesh: sum of its area vectors. The projected area of a flat */
  double folded;    /* mesh is |facing . d|; `folded`, a quarter of the rest of the area, is added */
  double area, strength;
  double near2;             /* quad: squared distance of its middle, within which its solid angle is sampled */
  float arriving[3];        /* relative to strength */
  bool infinite, by_square; /* `at` is a direction; irradiance still has to be divided by distance^2 */
  bool lobes;               /* Phong lobes are evaluated for it, */
  bool lobes_only;          /* and nothing else; */
  bool glass_stops;         /* what they add does not pass glass */
} pktrt__light_target;

typedef struct pktrt__shadow_rays { /* shadow rays of one light */
  float *o[3], *d[3], *time;        /* rows of the batch to be traced, or of a list from which packets are made */
  float *tmax_row;                  /* row of tmax; NULL in a list */
  float *contribution[3];           /* what the light adds if it is visible, */
  float *through[3];                /* and if it is so through glass; NULL: the same */
  uint32_t *surface, *material;     /* material: NULL if not wanted */
  float tmax;                       /* of all of them */
  uint32_t count;
} pktrt__shadow_rays;

typedef struct pktrt__shadow_list {
  PKTRT__ALIGN64 float o[3][PKTRT__ROW];
  float d[3][PKTRT__ROW], time[PKTRT__ROW], contribution[3][PKTRT__ROW], through[3][PKTRT__ROW];
  uint32_t surface[PKTRT__ROW], material[PKTRT__ROW];
} pktrt__shadow_list;

/* A request for rays of one type that surfaces send out. Their key is (key of the ray before + 1) * times + plus. */
typedef struct pktrt__spawn_request {
  const pktrt_scene *scene;
  const struct pktrt__glass_mesh *glass; /* see pktrt__render_state */
  bool refraction;
  bool lobes;      /* some are of lobes */
  float threshold; /* the least importance of a ray */
  uint32_t times, plus;
} pktrt__spawn_request;

/* A box around glass; the boxes within it, which leave out empty space, follow it depth first, and `next` is the number
   of steps to the box behind all of these. Boxes are wider than the glass by as much as a ray can hit outside, and as
   rounding takes: a small part of the largest coordinate. */
typedef struct pktrt__glass_box {
  float lo[3], hi[3];
  uint32_t next;
} pktrt__glass_box;
enum { PKTRT__BESIDE = 6 };
typedef struct pktrt__glass_mesh { /* the box of one mesh, over all its keys */
  float lo[3], hi[3];
  bool closed;                    /* a closed mesh of glass: only these have a box */
  uint32_t beside[PKTRT__BESIDE]; /* other closed meshes whose boxes touch this one, as far as there is room, */
  uint32_t beside_count;          /* and how many there are */
} pktrt__glass_mesh;
typedef struct pktrt__glass_boxes {
  pktrt__glass_box *boxes; /* NULL: shadow rays pass nothing */
  uint32_t room;           /* how many boxes there is room for */
  float least;             /* smaller components of directions count as this much */
} pktrt__glass_boxes;

/* The camera as a picture plane at distance 1: the ray of a pinhole through (px, py) in pixels goes along
   corner + px dx + py dy. A point of the lens, at x and y from its middle, sees the same point of the plane at
   distance `focus`: its ray goes along that minus (x right + y up) / focus. */
typedef struct pktrt__camera_plane {
  double eye[3], corner[3], dx[3], dy[3], right[3], up[3];
  double focus;
} pktrt__camera_plane;

PKTRT__INLINE const pktrt_material *pktrt__material_of(const pktrt_scene *s, uint32_t material) {
  return material ? &s->materials[material - 1] : &s->plain;
}
PKTRT__INLINE float pktrt__material_ior(const pktrt_material *mat, int a) {
  return mat->ior[a] > 0 ? mat->ior[a] : 1.5f;
}

#define PKTRT__PI 3.14159265358979323846
/* The series of sine and cosine, from the last term on; see pktrt__math_sincos. */
static const double pktrt__math_sine_terms[7] = {-1.0 / 1307674368000, 1.0 / 6227020800, -1.0 / 39916800, 1.0 / 362880,
                                                 -1.0 / 5040,          1.0 / 120,        -1.0 / 6};
static const double pktrt__math_cosine_terms[8] = {
    1.0 / 20922789888000, -1.0 / 87178291200, 1.0 / 479001600, -1.0 / 3628800, 1.0 / 40320, -1.0 / 720, 1.0 / 24, -0.5};
#define PKTRT__DISK_LEAST 1e-30 /* less than any coordinate but 0 in pktrt__map_to_disk */

static bool pktrt__material_has_lobe(const pktrt_material *mat) {
  return mat->lobe == PKTRT_LOBE_PHONG && pktrt__specular_rows[mat->specular].lobes;
}
static const pktrt__mesh *pktrt__mesh_source(const pktrt_scene *, uint32_t mesh);
static void pktrt__surface_place(const pktrt_scene *, const pktrt__wave *, pktrt__surfaces *, uint32_t i);
PKTRT__COLD void pktrt__surface_place_normals(const pktrt_scene *, uint32_t mesh, uint32_t triangle, float time,
                                              float n[3][3]);
static void pktrt__mesh_corner_at(const pktrt__mesh *, const float *data, uint32_t triangle, uint32_t c, float time,
                                  float out[3]);
static void pktrt__material_weights_rest(const pktrt_scene *, const pktrt__glass_mesh *, const pktrt__wave *,
                                         pktrt__surfaces *, uint32_t i, uint32_t metal, uint32_t glass);
static void pktrt__light_lobe_values(const pktrt_scene *, const pktrt__surfaces *, uint32_t i, uint32_t lanes,
                                     float (*to)[8], const pktrt__light_samples *listed, float lobe[8]);
static void pktrt__spawn_inherit(const pktrt__spawn_request *, const pktrt__wave *, const pktrt__surfaces *, uint32_t i,
                                 uint32_t lanes, uint32_t medium[8], uint32_t key[8]);

#endif /* PKTRT_NO_RENDER */

/* >>kernels: what an instruction set offers ------------------------------------------------------------------------ */

typedef struct pktrt__query { /* one query, as the kernels see it */
  const pktrt_scene *scene;
  const pktrt_query_desc *desc;
  pktrt_counts *counts; /* NULL: do not count */
  bool occlusion;
  /* What is prefetched meanwhile: the rays that come next, and the places of these rays' hits; NULL: nothing. WHY
     meanwhile: prefetched in a row, lines wait for one another. Spread over the work it saves 10% of easy scenes. */
  const pktrt_ray *next;
  const pktrt_hit *place;
  size_t first; /* of the batch's rays in the call, for events */
} pktrt__query;

#ifndef PKTRT_NO_PAPER
/* Returns the number of the first tree of a scene, or of a model in it. */
static uint32_t pktrt__tree_first(const pktrt_scene *s, const pktrt_scene *of) {
  uint32_t first = s == of ? 0 : s->bvh_count;
  for (uint32_t i = 0; s != of && s->models[i] != of; i++) first += s->models[i]->bvh_count;
  return first;
}
#endif

/* The variant of a kernel, whose flags each instance knows at compile time; counts is written only if stats is set. */
typedef struct pktrt__variant {
  bool occlusion, moving, stats;
  uint32_t mask; /* of the query, for those who choose trees */
  pktrt_counts *counts;
} pktrt__variant;
PKTRT__INLINE pktrt__variant pktrt__variant_of(const bool occlusion, const bool moving, const bool stats,
                                               pktrt_counts *counts) {
  pktrt__variant is;
  is.occlusion = occlusion, is.moving = moving, is.stats = stats, is.mask = UINT32_MAX, is.counts = counts;
  return is;
}
PKTRT__INLINE pktrt__variant pktrt__variant_moving(pktrt__variant is, const bool moving) {
  is.moving = moving;
  return is;
}

typedef struct pktrt__kernel_table {
  /* Answers rays [begin, end) of a batch whose o, d, tmin, tmax, time are filled in; see pktrt__query_trace. */
  void (*trace)(const pktrt__query *, pktrt__batch *, uint32_t begin, uint32_t end);
  /* Answers a single ray without a batch and without counts. */
  bool (*intersect)(const pktrt_scene *, const pktrt_ray *, uint32_t after, pktrt_hit *, uint32_t *where);
  bool (*occluded)(const pktrt_scene *, const pktrt_ray *);
  uint32_t (*check_arithmetic)(void); /* see pktrt__check_all_arithmetic */
  /* Loads n of the caller's rays into a batch, and stores the answers; order: which rays, NULL for the first ones. */
  void (*load_rays)(pktrt__batch *, const pktrt_ray *, const uint16_t *order, uint32_t n);
  void (*store_hits)(const pktrt_scene *, const pktrt__batch *, pktrt_hit *, const uint16_t *order, uint32_t n);
  void (*store_occluded)(const pktrt__batch *, bool *occluded, uint32_t n);
  void (*copy_row)(float *to, const float *from, uint32_t n);
  void (*store_names)(const pktrt_scene *, const pktrt__batch *, uint32_t *mesh, uint32_t *triangle, uint32_t n);
#ifndef PKTRT_NO_RENDER
  /* Writes the rays of a pinhole through eight places of the picture to lanes i to i + 7 of a wave. */
  void (*camera_rays)(const pktrt__camera_plane *, const double *x, const double *y, pktrt__wave *, uint32_t i);
  /* pack_surfaces packs those of n rays of a wave that hit something, and writes number and lanes to the surfaces.
     find_surfaces computes their points, normals and materials; normals of the mesh are read only if `smooth`. */
  void (*pack_surfaces)(pktrt__wave *, uint32_t first, uint32_t n, pktrt__surfaces *);
  void (*find_surfaces)(const pktrt_scene *, bool smooth, const pktrt__wave *, pktrt__surfaces *);
  /* evaluate_materials, after the hooks have run, computes scattering directions and weights of all surfaces if rays
     are followed (`follow`), and the radiance that needs no ray. shadow_rays makes those towards one light. visibility
     sets `seen` of n shadow rays to 0 or 1, lists the lanes of blocked ones that may meet glass, and returns how many,
     some too many. add_direct_light adds `seen` of what arrives by n shadow rays. spawn_rays appends reflected or
     refracted rays to the n of a wave, and returns how many it has then. */
  void (*evaluate_materials)(const pktrt_scene *, const pktrt__glass_mesh *, bool follow, const float ambient[3],
                             const pktrt__wave *, pktrt__surfaces *);
  void (*shadow_rays)(const pktrt_scene *, const pktrt__light_target *, const pktrt__wave *, pktrt__surfaces *,
                      pktrt__shadow_rays *);
  uint32_t (*visibility)(const pktrt__glass_boxes *, const pktrt__batch *, float (*seen)[PKTRT__ROW], uint32_t n,
                         uint32_t *lane);
  void (*add_direct_light)(pktrt__surfaces *, const uint32_t *surface, float (*arriving)[PKTRT__ROW],
                           float (*seen)[PKTRT__ROW], uint32_t n);
  uint32_t (*spawn_rays)(const pktrt__spawn_request *, const pktrt__wave *, const pktrt__surfaces *, pktrt__wave *to,
                         uint32_t n);
  /* Draws coordinates first to first + n - 1 of a group for PKTRT__DRAWN draws from the i-th on: Sobol' and random. */
  void (*draw_samples)(const pktrt_sampling *, pktrt__sample_batch *, uint32_t i, uint32_t group, uint32_t first,
                       uint32_t n);
#endif
} pktrt__kernel_table;

#define PKTRT__STAMP_SCALAR 1
#define PKTRT__STAMP_SSE2 2
#define PKTRT__STAMP_AVX2 3
#define PKTRT__STAMP_AVX512 4
#define PKTRT__STAMP_NEON 5
#define PKTRT__STAMP_WASM 6

/* >>check: arithmetic that is not what the code asks for ----------------------------------------------------------- */

/* Faults of arithmetic. No macro reveals some flags, and no compiler knows how a thread rounds: both are tested when a
   scene is created, in C and by the kernels that it will use. Only the first fault is reported: it can cause others. */
enum {
  PKTRT__ROUNDS_OTHERWISE = 1,
  PKTRT__FLUSHES = 2,
  PKTRT__SHORTENS = 4,
  PKTRT__FUSES = 8,
  PKTRT__REORDERS = 16,
  PKTRT__MULTIPLIES = 32,
  PKTRT__GUESSES_ROOTS = 64,
  PKTRT__EXPECTS_FINITE = 128,
  PKTRT__DROPS_SIGNS = 256
};

/* Returns x, hidden from compilers. */
PKTRT__NOINLINE double pktrt__check_opaque(double x) {
  volatile double v = x;
  return v;
}

/* Tests how this thread rounds, and whether it keeps numbers below DBL_MIN and FLT_MIN, as results and as operands. */
PKTRT__COLD uint32_t pktrt__check_thread(void) {
  const double one = pktrt__check_opaque(1), e = pktrt__check_opaque(DBL_EPSILON), tiny = pktrt__check_opaque(DBL_MIN);
  const float least = (float)pktrt__check_opaque((double)FLT_MIN),
              large = (float)pktrt__check_opaque(1 / (double)FLT_EPSILON);
  const bool nearest = one + e * 0.75 == 1 + DBL_EPSILON && one + e * 0.25 == 1 && -one - e * 0.25 == -1;
  volatile float low = least * 0.25f; /* written and read: flushed here, or below */
  volatile double deep = tiny * 0.25;
  const bool kept = low * large == FLT_MIN * 0.25f * (1 / FLT_EPSILON) && deep * pktrt__check_opaque(4) == DBL_MIN;
  return (nearest ? 0 : PKTRT__ROUNDS_OTHERWISE) | (kept ? 0 : PKTRT__FLUSHES);
}

/* Tests what the compiler made of arithmetic: (1 + e)^2 - (1 + 2 e), e = 2^-12 or 2^-27, is e^2 if fused, else 0. */
PKTRT__DIVIDES_BY_ZERO PKTRT__COLD uint32_t pktrt__check_compiler(void) {
  volatile float x = 1.000244140625f, y = 1.00048828125f; /* read anew: a product with two uses would not be fused */
  volatile double v = 1.00000000745058059692, w = 1.00000001490116119385;
  const float a = x, b = y, c = x, d = y;
  const double e = v, f = w, g = v, h = w, one = pktrt__check_opaque(1), big = pktrt__check_opaque(18014398509481984.0);
  const double divisor = pktrt__check_opaque(99), q5 = pktrt__check_opaque(5) / divisor,
               q7 = pktrt__check_opaque(7) / divisor;
  const double negative = pktrt__check_opaque(-0.0), infinite = one / pktrt__check_opaque(0), nan = infinite - infinite;
  const bool apart = a * a - b == 0 && d - c * c == 0 && e * e - f == 0 && h - g * g == 0;
  const bool divides = q5 == 0.050505050505050504 && q7 == 0.070707070707070704;
  const bool roots =
      sqrt(pktrt__check_opaque(2)) == 1.4142135623730951 && sqrtf((float)pktrt__check_opaque(3)) == 1.73205078f;
  const bool finite = nan == nan || nan <= one || !(one < infinite) || !(infinite - one == infinite);
  const bool signs = 1 / (negative + 0.0) > 0 && 1 / (0.0 - pktrt__check_opaque(0)) > 0;
  return (sizeof 1.0 == sizeof one ? 0 : PKTRT__SHORTENS) | (apart ? 0 : PKTRT__FUSES) |
         ((one + big) - big == 0 ? 0 : PKTRT__REORDERS) | (divides ? 0 : PKTRT__MULTIPLIES) |
         (roots ? 0 : PKTRT__GUESSES_ROOTS) | (finite ? PKTRT__EXPECTS_FINITE : 0) | (signs ? 0 : PKTRT__DROPS_SIGNS);
}

PKTRT__COLD const char *pktrt__check_sentence(uint32_t faults) {
#define PKTRT__REFUSED "A scene could not be created: "
  switch (faults & (~faults + 1)) {
  case PKTRT__ROUNDS_OTHERWISE:
    return PKTRT__REFUSED "this thread does not round to nearest; fesetround(FE_TONEAREST).";
  case PKTRT__FLUSHES:
    return PKTRT__REFUSED "this thread flushes denormal numbers to zero; link without -ffast-math, -Ofast, "
                          "-funsafe-math-optimizations and -mdaz-ftz, which set this at the start, or clear it.";
  case PKTRT__SHORTENS: return PKTRT__REFUSED "double constants became floats; drop -fsingle-precision-constant.";
  case PKTRT__FUSES:
    return PKTRT__REFUSED "products and sums are fused; drop -ffp-contract=fast, -ffast-math and -ffp-model=fast.";
  case PKTRT__REORDERS:
    return PKTRT__REFUSED "sums are reordered; drop -fassociative-math, -funsafe-math-optimizations and -ffast-math.";
  case PKTRT__MULTIPLIES:
    return PKTRT__REFUSED
        "divisions are not exact; drop -freciprocal-math, -funsafe-math-optimizations and -ffast-math.";
  case PKTRT__GUESSES_ROOTS:
    return PKTRT__REFUSED "square roots are not exact; drop -fapprox-func, -mrecip and -ffast-math.";
  case PKTRT__EXPECTS_FINITE:
    return PKTRT__REFUSED "NaN and infinities are ruled out; drop -ffinite-math-only, -fno-honor-nans and "
                          "-fno-honor-infinities.";
  case PKTRT__DROPS_SIGNS: return PKTRT__REFUSED "zeros lose their signs; drop -fno-signed-zeros and -ffast-math.";
  default:
    return PKTRT__REFUSED "out of memory, an instruction set that pktrt_isa_available denies, only one of the allocate "
                          "and release hooks, or an enumerator out of range.";
  }
#undef PKTRT__REFUSED
}

/* >>stamping ------------------------------------------------------------------------------------------------------- */

#ifndef PKTRT_HEADER_FILENAME /* how this file names itself; define it if you renamed the file */
#define PKTRT_HEADER_FILENAME "pktrt.h"
#endif
/* Kernels use short macros, which are undefined after each stamp; macros of a program or <tgmath.h> are put aside. */
#pragma push_macro("COUNT")
#pragma push_macro("COUNTED")
#pragma push_macro("OP")
#pragma push_macro("STEP")
#pragma push_macro("UNROLL")
#pragma push_macro("FW")
#pragma push_macro("INSTANCE")
#pragma push_macro("dadd")
#pragma push_macro("ddiv")
#pragma push_macro("dmul")
#pragma push_macro("dsqrt")
#pragma push_macro("dsub")
#pragma push_macro("fadd")
#pragma push_macro("fdiv")
#pragma push_macro("ffma")
#pragma push_macro("fmul")
#pragma push_macro("fsub")
#undef COUNT
#undef COUNTED
#undef OP
#undef STEP
#undef SHARED
#undef PKTRT__SPAWN_RAYS
#undef PKTRT__MATERIAL_EVALUATE
#undef UNROLL
#undef FW
#undef INSTANCE
#undef dadd
#undef ddiv
#undef dmul
#undef dsqrt
#undef dsub
#undef fadd
#undef fdiv
#undef ffma
#undef fmul
#undef fsub

#define PKTRT__PASTE2(a, b) a##_##b
#define PKTRT__PASTE(a, b) PKTRT__PASTE2(a, b)
#define PKTRT__NAME(x) PKTRT__PASTE(x, PKTRT__SUFFIX)

/* An editor shows a file once: it gets the scalar kernels where they stand (.clangd asks for it). */
#ifdef PKTRT__EDITOR
#define PKTRT__STAMP PKTRT__STAMP_SCALAR
#define PKTRT__SUFFIX scalar
#else
#ifdef PKTRT__HAS_SSE2
#define PKTRT__STAMP PKTRT__STAMP_SSE2
#define PKTRT__SUFFIX sse2
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#endif

#ifdef PKTRT__HAS_NEON
#define PKTRT__STAMP PKTRT__STAMP_NEON
#define PKTRT__SUFFIX neon
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#endif

#ifdef PKTRT__HAS_WASM
#define PKTRT__STAMP PKTRT__STAMP_WASM
#define PKTRT__SUFFIX wasm
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#endif

#ifdef PKTRT__HAS_SCALAR
#define PKTRT__STAMP PKTRT__STAMP_SCALAR
#define PKTRT__SUFFIX scalar
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#endif

#ifdef PKTRT__HAS_AVX2 /* enabled per function: the rest of the program needs no -mavx2 */
#ifdef __clang__
#pragma clang attribute push(__attribute__((__target__("avx2,fma,bmi,bmi2,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,popcnt")
#endif
#define PKTRT__STAMP PKTRT__STAMP_AVX2
#define PKTRT__SUFFIX avx2
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#ifdef PKTRT__HAS_AVX512
#ifdef __clang__
#pragma clang attribute push( \
    __attribute__((__target__("avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi,bmi2,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi,bmi2,popcnt")
#endif
#define PKTRT__STAMP PKTRT__STAMP_AVX512
#define PKTRT__SUFFIX avx512
#include PKTRT_HEADER_FILENAME
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#endif /* PKTRT__EDITOR */

#pragma pop_macro("COUNT")
#pragma pop_macro("COUNTED")
#pragma pop_macro("OP")
#pragma pop_macro("STEP")
#pragma pop_macro("UNROLL")
#pragma pop_macro("FW")
#pragma pop_macro("INSTANCE")
#pragma pop_macro("dadd")
#pragma pop_macro("ddiv")
#pragma pop_macro("dmul")
#pragma pop_macro("dsqrt")
#pragma pop_macro("dsub")
#pragma pop_macro("fadd")
#pragma pop_macro("fdiv")
#pragma pop_macro("ffma")
#pragma pop_macro("fmul")
#pragma pop_macro("fsub")

#endif /* PKTRT__IMPLEMENTED */
#endif /* PKTRT_IMPLEMENTATION */

/* ---------------------------------------------------------------------------------------------------------------------
   IMPLEMENTATION, stamped once per instruction set: this file includes itself with PKTRT__STAMP defined
   ------------------------------------------------------------------------------------------------------------------ */
#ifdef PKTRT__STAMP

/* >>ops -------------------------------------------------------------------------------------------------------------

   The only place where instruction sets differ. v8: eight floats. m8: a mask of eight lanes. d8: eight doubles. vf: the
   vector of rays in a frustum packet, 16 floats on AVX-512 and v8 elsewhere. Operations are small functions; min and
   max are a < b ? a : b and a > b ? a : b everywhere, so that NaN gives the same result; vfma and vfms fuse where the
   machine can and are for conservative culling only. Masks become integers by mbits: lane i is bit i. */

#define v8 PKTRT__NAME(pktrt__v8)
#define m8 PKTRT__NAME(pktrt__m8)
#define d8 PKTRT__NAME(pktrt__d8)
#define a8 PKTRT__NAME(pktrt__a8)
#define vload PKTRT__NAME(pktrt__vload)
#define vstore PKTRT__NAME(pktrt__vstore)
#define vset PKTRT__NAME(pktrt__vset)
#define vadd PKTRT__NAME(pktrt__vadd)
#define vsub PKTRT__NAME(pktrt__vsub)
#define vmul PKTRT__NAME(pktrt__vmul)
#define vdiv PKTRT__NAME(pktrt__vdiv)
#define vsqrt PKTRT__NAME(pktrt__vsqrt)
#define vfma PKTRT__NAME(pktrt__vfma)
#define vfms PKTRT__NAME(pktrt__vfms)
#define vmin PKTRT__NAME(pktrt__vmin)
#define vmax PKTRT__NAME(pktrt__vmax)
#define vabs PKTRT__NAME(pktrt__vabs)
#define vsel PKTRT__NAME(pktrt__vsel)
#define vlt PKTRT__NAME(pktrt__vlt)
#define vle PKTRT__NAME(pktrt__vle)
#define veq PKTRT__NAME(pktrt__veq)
#define vsignbits PKTRT__NAME(pktrt__vsignbits)
#define vcopysign PKTRT__NAME(pktrt__vcopysign)
#define mand PKTRT__NAME(pktrt__mand)
#define mor PKTRT__NAME(pktrt__mor)
#define mbits PKTRT__NAME(pktrt__mbits)
#define mfrom PKTRT__NAME(pktrt__mfrom)
#define mturn PKTRT__NAME(pktrt__mturn)
#define vstore_masked PKTRT__NAME(pktrt__vstore_masked)
#define vstore_masked_u32 PKTRT__NAME(pktrt__vstore_masked_u32)
#define veq_u32 PKTRT__NAME(pktrt__veq_u32)
#define vtranspose PKTRT__NAME(pktrt__vtranspose)
#define vbelow_u32 PKTRT__NAME(pktrt__vbelow_u32)
#define vorder_children PKTRT__NAME(pktrt__vorder_children)
#define vbytes PKTRT__NAME(pktrt__vbytes)
#define vstore_bytes PKTRT__NAME(pktrt__vstore_bytes)
#define veq_u8x64 PKTRT__NAME(pktrt__veq_u8x64)
#define c8 PKTRT__NAME(pktrt__c8)
#define vchoose PKTRT__NAME(pktrt__vchoose)
#define vcompress PKTRT__NAME(pktrt__vcompress)
#define vcompress_from PKTRT__NAME(pktrt__vcompress_from)
#define vswap_halves PKTRT__NAME(pktrt__vswap_halves)
#define vload_turn PKTRT__NAME(pktrt__vload_turn)
#define vstore_turn PKTRT__NAME(pktrt__vstore_turn)
#define vturn PKTRT__NAME(pktrt__vturn)
#define vhmin PKTRT__NAME(pktrt__vhmin)
#define vhmax PKTRT__NAME(pktrt__vhmax)
#define dload PKTRT__NAME(pktrt__dload)
#define dstore PKTRT__NAME(pktrt__dstore)
#define dload_low PKTRT__NAME(pktrt__dload_low)
#define dload_twice PKTRT__NAME(pktrt__dload_twice)
#define dspread PKTRT__NAME(pktrt__dspread)
#define dhalves PKTRT__NAME(pktrt__dhalves)
#define drotate PKTRT__NAME(pktrt__drotate)
#define dsqrt PKTRT__NAME(pktrt__dsqrt)
#define dfrom PKTRT__NAME(pktrt__dfrom)
#define dset PKTRT__NAME(pktrt__dset)
#define dadd PKTRT__NAME(pktrt__dadd)
#define dsub PKTRT__NAME(pktrt__dsub)
#define dmul PKTRT__NAME(pktrt__dmul)
#define ddiv PKTRT__NAME(pktrt__ddiv)
#define dmax PKTRT__NAME(pktrt__dmax)
#define dabs PKTRT__NAME(pktrt__dabs)
#define dlt PKTRT__NAME(pktrt__dlt)
#define dsel PKTRT__NAME(pktrt__dsel)
#define dto PKTRT__NAME(pktrt__dto)
#define vmax_abs PKTRT__NAME(pktrt__vmax_abs)
#define vmax_abs3 PKTRT__NAME(pktrt__vmax_abs3)
#define azero PKTRT__NAME(pktrt__azero)
#define aor PKTRT__NAME(pktrt__aor)
#define apush PKTRT__NAME(pktrt__apush)
#define OP PKTRT__INLINE
/* Capabilities of the instruction set, which kernels may test. */
/* A v8 is one register: larger functions are worth inlining. */
#define PKTRT__WITH_V8_REGISTERS (PKTRT__STAMP == PKTRT__STAMP_AVX2 || PKTRT__STAMP == PKTRT__STAMP_AVX512)
/* Sixteen registers do not hold the nine vectors of a ray that box tests need, and to broadcast one from memory costs
   no more than to load it: each is broadcast where it is used. Measured worth 5% of a single ray's time. */
#define PKTRT__WITH_FEW_REGISTERS (PKTRT__STAMP == PKTRT__STAMP_AVX2)
#define PKTRT__WITH_VECTORS (PKTRT__STAMP != PKTRT__STAMP_SCALAR)
/* Packets go through the top level as such; elsewhere as streams, which is less code. */
#if PKTRT__WITH_V8_REGISTERS && !defined(PKTRT_NO_FRUSTA) && !defined(PKTRT__NO_TOP)
#define PKTRT__WITH_TOP_FRUSTA 1
#else
#define PKTRT__WITH_TOP_FRUSTA 0
#endif
/* Where there are vectors, scalar kernels need not be fast: they have fewer instances, see PKTRT__VARIANTS. */
#if PKTRT__STAMP == PKTRT__STAMP_SCALAR && defined(PKTRT__HAS_BASE)
#define PKTRT__WITH_FEW_INSTANCES 1
#else
#define PKTRT__WITH_FEW_INSTANCES 0
#endif
/* The instruction sets with kernels for builds, refits and samples of lights. WHY not all: 512 bits would gain nothing
   here, and the set that every x86 or ARM has serves scalar scenes as well, with the same bits and less code. */
#if PKTRT__STAMP == PKTRT__STAMP_AVX2 || PKTRT__STAMP == PKTRT__STAMP_SSE2 || PKTRT__STAMP == PKTRT__STAMP_NEON || \
    PKTRT__STAMP == PKTRT__STAMP_WASM || (PKTRT__STAMP == PKTRT__STAMP_SCALAR && !defined(PKTRT__HAS_BASE)) ||     \
    !(defined(PKTRT__HAS_SCALAR) || defined(PKTRT__HAS_SSE2) || defined(PKTRT__HAS_AVX2))
#define PKTRT__WITH_FIT 1
#else
#define PKTRT__WITH_FIT 0
#endif
/* The set has kernels for the paper's path, counts, evaluates materials and spawns rays. WHY not AVX-512: 1% to 3% there,
   with 18 KB, and less of DRT's time by the others; nobody races what counts. AVX2 serves for it. */
#if PKTRT__STAMP == PKTRT__STAMP_AVX512 && defined(PKTRT__HAS_AVX2) && !defined(PKTRT__ALSO_STAMP)
#define PKTRT__WITH_PAPER 0
#else
#define PKTRT__WITH_PAPER 1
#endif
/* WHY not the scalar set where there are vectors: shading with all its instances would be a twentieth of the time that the
   header takes to compile. */
#if PKTRT__WITH_FEW_INSTANCES && !defined(PKTRT__EDITOR)
#define PKTRT__WITH_SHADE 0
#else
#define PKTRT__WITH_SHADE 1
#endif
/* WHY not the scalar set where there are vectors: it would be 10 KB for a path that is there to be read and compared. */
#if !PKTRT__WITH_PAPER || (PKTRT__WITH_FEW_INSTANCES && !defined(PKTRT__ALSO_STAMP) && !defined(PKTRT__EDITOR))
#define PKTRT__WITH_PAPER_PATH 0
#else
#define PKTRT__WITH_PAPER_PATH 1
#endif
/* The kernels that scalar ones are stamped behind, and which serve for what these lack. */
#if defined(PKTRT__HAS_NEON)
#define PKTRT__BASE(x) x##_neon
#elif defined(PKTRT__HAS_WASM)
#define PKTRT__BASE(x) x##_wasm
#else
#define PKTRT__BASE(x) x##_sse2
#endif
/* UNROLL stands before short loops over axes or corners: gcc -O2 would keep their vectors in memory otherwise. */
#if PKTRT__STAMP != PKTRT__STAMP_SCALAR && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__)
#define UNROLL _Pragma("GCC unroll 8")
#else
#define UNROLL
#endif

#if PKTRT__STAMP == PKTRT__STAMP_AVX2 || PKTRT__STAMP == PKTRT__STAMP_AVX512

typedef __m256 v8;
OP v8 vload(const float *p) { return _mm256_loadu_ps(p); }
OP void vstore(float *p, v8 a) { _mm256_storeu_ps(p, a); }
OP v8 vset(float x) { return _mm256_set1_ps(x); }
OP v8 vadd(v8 a, v8 b) { return _mm256_add_ps(a, b); }
OP v8 vsub(v8 a, v8 b) { return _mm256_sub_ps(a, b); }
OP v8 vmul(v8 a, v8 b) { return _mm256_mul_ps(a, b); }
OP v8 vdiv(v8 a, v8 b) { return _mm256_div_ps(a, b); }
OP v8 vsqrt(v8 a) { return _mm256_sqrt_ps(a); }
OP v8 vfma(v8 a, v8 b, v8 c) { return _mm256_fmadd_ps(a, b, c); }
OP v8 vfms(v8 a, v8 b, v8 c) { return _mm256_fmsub_ps(a, b, c); }
OP v8 vmin(v8 a, v8 b) { return _mm256_min_ps(a, b); }
OP v8 vmax(v8 a, v8 b) { return _mm256_max_ps(a, b); }
OP v8 vabs(v8 a) { return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a); }
OP v8 vcopysign(v8 magnitude, v8 sign) { /* magnitude >= 0 */
  return _mm256_or_ps(magnitude, _mm256_and_ps(_mm256_set1_ps(-0.0f), sign));
}
OP uint32_t vsignbits(v8 a) { return (uint32_t)_mm256_movemask_ps(a); }
OP v8 vswap_halves(v8 a) { return _mm256_permute2f128_ps(a, a, 1); } /* its halves */
OP float vhmax(v8 a) {
  __m128 x = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
  x = _mm_max_ps(x, _mm_movehl_ps(x, x));
  return _mm_cvtss_f32(_mm_max_ss(x, _mm_shuffle_ps(x, x, 1)));
}

#ifdef __x86_64__
/* Lists those of eight children that are in `keep`, in the order of perm, as bytes, the first one lowest. */
OP uint64_t vorder_children(uint32_t keep, uint32_t perm) {
  const uint64_t all = _pdep_u64(perm, UINT64_C(0x0707070707070707));
  const uint64_t kept = _pdep_u64(keep, UINT64_C(0x0101010101010101)) * 0xFF;
  const __m128i those = _mm_shuffle_epi8(_mm_cvtsi64_si128((long long)kept), _mm_cvtsi64_si128((long long)all));
  return _pext_u64(all, (uint64_t)_mm_cvtsi128_si64(those));
}
#endif
/* Writes eight integers from p, less x, to `to`; returns the lanes where the difference is below n, which is not 0. */
OP uint32_t vbelow_u32(uint32_t *to, const uint32_t *p, uint32_t x, uint32_t n) {
  const __m256i a = _mm256_sub_epi32(_mm256_loadu_si256((const __m256i *)(const void *)p), _mm256_set1_epi32((int)x));
  const __m256i low = _mm256_cmpeq_epi32(_mm256_min_epu32(a, _mm256_set1_epi32((int)(n - 1))), a);
  _mm256_storeu_si256((__m256i *)(void *)to, a);
  return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(low));
}
/* Transposes eight vectors. */
OP void vtranspose(v8 r[8]) {
  v8 a[8], b[8];
  UNROLL for (int i = 0; i < 8; i += 2) {
    a[i] = _mm256_unpacklo_ps(r[i], r[i + 1]), a[i + 1] = _mm256_unpackhi_ps(r[i], r[i + 1]);
  }
  UNROLL for (int i = 0; i < 8; i += 4) {
    UNROLL for (int j = 0; j < 2; j++) {
      b[i + 2 * j] = _mm256_shuffle_ps(a[i + j], a[i + j + 2], 0x44);
      b[i + 2 * j + 1] = _mm256_shuffle_ps(a[i + j], a[i + j + 2], 0xEE);
    }
  }
  UNROLL for (int i = 0; i < 4; i++) {
    r[i] = _mm256_permute2f128_ps(b[i], b[i + 4], 0x20);
    r[i + 4] = _mm256_permute2f128_ps(b[i], b[i + 4], 0x31);
  }
}

#if PKTRT__STAMP == PKTRT__STAMP_AVX512

typedef __mmask8 m8;
OP m8 vlt(v8 a, v8 b) { return _mm256_cmp_ps_mask(a, b, _CMP_LT_OQ); }
OP m8 vle(v8 a, v8 b) { return _mm256_cmp_ps_mask(a, b, _CMP_LE_OQ); }
OP m8 veq(v8 a, v8 b) { return _mm256_cmp_ps_mask(a, b, _CMP_EQ_OQ); }
OP m8 mand(m8 a, m8 b) { return (m8)(a & b); }
OP m8 mor(m8 a, m8 b) { return (m8)(a | b); }
OP uint32_t mbits(m8 m) { return m; }
OP m8 mfrom(uint32_t bits) { return (m8)bits; }
OP v8 vsel(m8 m, v8 a, v8 b) { return _mm256_mask_blend_ps(m, b, a); }
OP void vstore_masked(float *p, m8 m, v8 a) { _mm256_mask_storeu_ps(p, m, a); }
OP void vstore_masked_u32(uint32_t *p, m8 m, uint32_t x) { _mm256_mask_storeu_epi32(p, m, _mm256_set1_epi32((int)x)); }
OP uint32_t veq_u32(const uint32_t *p, uint32_t x) { /* the lanes that equal x */
  return _mm256_cmpeq_epi32_mask(_mm256_loadu_si256((const __m256i *)(const void *)p), _mm256_set1_epi32((int)x));
}

/* Packs the chosen lanes of a vector to p (vcompress_from: of eight floats or integers in memory, which may be those at
   p). What follows them, up to eight values in all, may be overwritten: masked stores were slower. vchoose: the choice. */
typedef m8 c8;
OP c8 vchoose(uint32_t lanes) { return (m8)lanes; }
OP void vcompress(float *p, c8 lanes, v8 a) { _mm256_storeu_ps(p, _mm256_maskz_compress_ps(lanes, a)); }
OP void vcompress_from(void *p, c8 lanes, const void *from) {
  const __m256i a = _mm256_loadu_si256(PKTRT__CAST(const __m256i *, from));
  _mm256_storeu_si256(PKTRT__CAST(__m256i *, p), _mm256_maskz_compress_epi32(lanes, a));
}

typedef __m512d d8;
OP d8 dload(const double *p) { return _mm512_loadu_pd(p); }
OP d8 dload_low(const double *p) { return _mm512_maskz_loadu_pd(0x0F, p); }
OP d8 dload_twice(const double *p) { return _mm512_broadcast_f64x4(_mm256_loadu_pd(p)); }
OP d8 dhalves(d8 a, d8 b, const int which) { /* low and low, high and high, or high and low */
  return which == 0   ? _mm512_shuffle_f64x2(a, b, 0x44)
         : which == 1 ? _mm512_shuffle_f64x2(a, b, 0xEE)
                      : _mm512_shuffle_f64x2(a, b, 0x4E);
}
OP d8 drotate(d8 a, const int by) { return by == 1 ? _mm512_permutex_pd(a, 0xC9) : _mm512_permutex_pd(a, 0xD2); }
OP d8 dspread(d8 a, const int i) {
  return i == 0 ? _mm512_permutex_pd(a, 0) : i == 1 ? _mm512_permutex_pd(a, 0x55) : _mm512_permutex_pd(a, 0xAA);
}
OP void dstore(double *p, d8 a) { _mm512_storeu_pd(p, a); }
OP d8 dsqrt(d8 a) { return _mm512_sqrt_pd(a); }
OP d8 dfrom(v8 a) { return _mm512_cvtps_pd(a); }
OP d8 dset(double x) { return _mm512_set1_pd(x); }
OP d8 dadd(d8 a, d8 b) { return _mm512_add_pd(a, b); }
OP d8 dsub(d8 a, d8 b) { return _mm512_sub_pd(a, b); }
OP d8 dmul(d8 a, d8 b) { return _mm512_mul_pd(a, b); }
OP d8 ddiv(d8 a, d8 b) { return _mm512_div_pd(a, b); }
OP d8 dmax(d8 a, d8 b) { return _mm512_max_pd(a, b); }
OP d8 dabs(d8 a) { return _mm512_abs_pd(a); }
OP m8 dlt(d8 a, d8 b) { return _mm512_cmp_pd_mask(a, b, _CMP_LT_OQ); }
OP d8 dsel(m8 m, d8 a, d8 b) { return _mm512_mask_blend_pd(m, b, a); }
OP v8 dto(d8 a) { return _mm512_cvtpd_ps(a); }

typedef __m512i a8; /* eight ray masks, one per child */
OP a8 azero(void) { return _mm512_setzero_si512(); }
OP a8 aor(a8 a, m8 m, uint32_t bit) {
  return _mm512_mask_or_epi64(a, m, a, _mm512_set1_epi64((long long)((uint64_t)1 << bit)));
}

/* Pushes the children with a non-empty ray mask, in the order of perm; returns how many. Compresses in registers,
   because compressing stores are slow on some CPUs. */
OP uint32_t apush(a8 a, const uint32_t *child, v8 dist, uint32_t perm, uint64_t *masks, uint32_t *refs, float *nears) {
  const __m256i order = _mm256_srlv_epi32(_mm256_set1_epi32((int)perm), _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21));
  const __m512i wide = _mm512_cvtepu32_epi64(_mm256_and_si256(order, _mm256_set1_epi32(7)));
  a = _mm512_permutexvar_epi64(wide, a);
  const __m256i c = _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const __m256i *)(const void *)child), order);
  const __m256 d = _mm256_permutevar8x32_ps(dist, order);
  const __mmask8 some = _mm512_test_epi64_mask(a, a);
  _mm512_storeu_si512(masks, _mm512_maskz_compress_epi64(some, a));
  _mm256_storeu_si256((__m256i *)(void *)refs, _mm256_maskz_compress_epi32(some, c));
  _mm256_storeu_ps(nears, _mm256_maskz_compress_ps(some, d));
  return pktrt__popcount(some);
}

#else /* AVX2 */

typedef __m256 m8;
OP m8 vlt(v8 a, v8 b) { return _mm256_cmp_ps(a, b, _CMP_LT_OQ); }
OP m8 vle(v8 a, v8 b) { return _mm256_cmp_ps(a, b, _CMP_LE_OQ); }
OP m8 veq(v8 a, v8 b) { return _mm256_cmp_ps(a, b, _CMP_EQ_OQ); }
OP m8 mand(m8 a, m8 b) { return _mm256_and_ps(a, b); }
OP m8 mor(m8 a, m8 b) { return _mm256_or_ps(a, b); }
OP uint32_t mbits(m8 m) { return (uint32_t)_mm256_movemask_ps(m); }
OP m8 mfrom(uint32_t bits) {
  const __m256i lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
  return _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32((int)bits), lane), lane));
}
OP v8 vsel(m8 m, v8 a, v8 b) { return _mm256_blendv_ps(b, a, m); }
OP void vstore_masked(float *p, m8 m, v8 a) {
  vstore(p, vsel(m, a, vload(p)));
} /* WHY: masked stores are slow on AMD's */
OP void vstore_masked_u32(uint32_t *p, m8 m, uint32_t x) {
  float *to = PKTRT__CAST(float *, PKTRT__CAST(void *, p)); /* bits are kept */
  vstore_masked(to, m, _mm256_castsi256_ps(_mm256_set1_epi32((int)x)));
}
OP uint32_t veq_u32(const uint32_t *p, uint32_t x) { /* the lanes that equal x */
  const __m256i a = _mm256_loadu_si256((const __m256i *)(const void *)p);
  return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_cmpeq_epi32(a, _mm256_set1_epi32((int)x))));
}

#define d8_of PKTRT__NAME(pktrt__d8_of)
typedef struct d8 {
  __m256d l, h;
} d8;
OP d8 d8_of(__m256d l, __m256d h) {
  d8 r;
  r.l = l, r.h = h;
  return r;
}
OP d8 dfrom(v8 a) {
  return d8_of(_mm256_cvtps_pd(_mm256_castps256_ps128(a)), _mm256_cvtps_pd(_mm256_extractf128_ps(a, 1)));
}
OP d8 dload(const double *p) { return d8_of(_mm256_loadu_pd(p), _mm256_loadu_pd(p + 4)); }
OP d8 dload_low(const double *p) { return d8_of(_mm256_loadu_pd(p), _mm256_setzero_pd()); }
OP d8 dload_twice(const double *p) { return d8_of(_mm256_loadu_pd(p), _mm256_loadu_pd(p)); }
OP d8 dhalves(d8 a, d8 b, const int which) { /* low and low, high and high, or high and low */
  return d8_of(which ? a.h : a.l, which == 1 ? b.h : b.l);
}
OP d8 drotate(d8 a, const int by) {
  return by == 1 ? d8_of(_mm256_permute4x64_pd(a.l, 0xC9), _mm256_permute4x64_pd(a.h, 0xC9))
                 : d8_of(_mm256_permute4x64_pd(a.l, 0xD2), _mm256_permute4x64_pd(a.h, 0xD2));
}
OP d8 dspread(d8 a, const int i) {
  return i == 0   ? d8_of(_mm256_permute4x64_pd(a.l, 0), _mm256_permute4x64_pd(a.h, 0))
         : i == 1 ? d8_of(_mm256_permute4x64_pd(a.l, 0x55), _mm256_permute4x64_pd(a.h, 0x55))
                  : d8_of(_mm256_permute4x64_pd(a.l, 0xAA), _mm256_permute4x64_pd(a.h, 0xAA));
}
OP void dstore(double *p, d8 a) {
  _mm256_storeu_pd(p, a.l);
  _mm256_storeu_pd(p + 4, a.h);
}
OP d8 dsqrt(d8 a) { return d8_of(_mm256_sqrt_pd(a.l), _mm256_sqrt_pd(a.h)); }
OP d8 dset(double x) { return d8_of(_mm256_set1_pd(x), _mm256_set1_pd(x)); }
OP d8 dadd(d8 a, d8 b) { return d8_of(_mm256_add_pd(a.l, b.l), _mm256_add_pd(a.h, b.h)); }
OP d8 dsub(d8 a, d8 b) { return d8_of(_mm256_sub_pd(a.l, b.l), _mm256_sub_pd(a.h, b.h)); }
OP d8 dmul(d8 a, d8 b) { return d8_of(_mm256_mul_pd(a.l, b.l), _mm256_mul_pd(a.h, b.h)); }
OP d8 ddiv(d8 a, d8 b) { return d8_of(_mm256_div_pd(a.l, b.l), _mm256_div_pd(a.h, b.h)); }
OP d8 dmax(d8 a, d8 b) { return d8_of(_mm256_max_pd(a.l, b.l), _mm256_max_pd(a.h, b.h)); }
OP d8 dabs(d8 a) {
  const __m256d sign = _mm256_set1_pd(-0.0);
  return d8_of(_mm256_andnot_pd(sign, a.l), _mm256_andnot_pd(sign, a.h));
}
OP m8 dlt(d8 a, d8 b) {
  const __m256 l = _mm256_castpd_ps(_mm256_cmp_pd(a.l, b.l, _CMP_LT_OQ));
  const __m256 h = _mm256_castpd_ps(_mm256_cmp_pd(a.h, b.h, _CMP_LT_OQ));
  const __m256d mixed = _mm256_castps_pd(_mm256_shuffle_ps(l, h, 0x88)); /* l01 h01 l23 h23 */
  return _mm256_castpd_ps(_mm256_permute4x64_pd(mixed, 0xD8));
}
OP d8 dsel(m8 m, d8 a, d8 b) {
  const __m128i l = _mm_castps_si128(_mm256_castps256_ps128(m)), h = _mm_castps_si128(_mm256_extractf128_ps(m, 1));
  return d8_of(_mm256_blendv_pd(b.l, a.l, _mm256_castsi256_pd(_mm256_cvtepi32_epi64(l))),
               _mm256_blendv_pd(b.h, a.h, _mm256_castsi256_pd(_mm256_cvtepi32_epi64(h))));
}
OP v8 dto(d8 a) { return _mm256_set_m128(_mm256_cvtpd_ps(a.h), _mm256_cvtpd_ps(a.l)); }
#endif
#define PKTRT__TURNS 1u
OP v8 vturn(v8 a, uint32_t turn) { return (void)turn, a; }
OP v8 vload_turn(const float *p, uint32_t turn) { return (void)turn, vload(p); }
OP void vstore_turn(float *p, v8 a) { vstore(p, a); }
OP uint32_t mturn(m8 m) { return mbits(m); }

#elif PKTRT__STAMP == PKTRT__STAMP_SCALAR

/* Where there are vectors, only those scalar operations are inlined that make less code than a call, which copies its
   arguments: all of them would be little faster, and the whole header would take longer to compile. */
#undef OP
#if defined(PKTRT__INLINE_SCALAR) || \
    !(defined(PKTRT__HAS_BASE) || defined(PKTRT__HAS_AVX2) || defined(PKTRT__HAS_AVX512))
#define OP static inline
#else
#define OP PKTRT__NOINLINE
#endif
typedef struct v8 {
  float f[8];
} v8;
typedef uint32_t m8;
typedef struct d8 {
  double d[8];
} d8;
#define PKTRT__EACH(type, expression)     \
  type r;                                 \
  for (int i = 0; i < 8; i++) expression; \
  return r
PKTRT__INLINE v8 vload(const float *p) {
  v8 r;
  memcpy(r.f, p, sizeof r.f);
  return r;
}
PKTRT__INLINE void vstore(float *p, v8 a) { memcpy(p, a.f, sizeof a.f); }
PKTRT__INLINE v8 vset(float x) { PKTRT__EACH(v8, r.f[i] = x); }
PKTRT__INLINE v8 vadd(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] + b.f[i]); }
PKTRT__INLINE v8 vsub(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] - b.f[i]); }
PKTRT__INLINE v8 vmul(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] * b.f[i]); }
PKTRT__DIVIDES_BY_ZERO PKTRT__INLINE v8 vdiv(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] / b.f[i]); }
PKTRT__INLINE v8 vsqrt(v8 a) { PKTRT__EACH(v8, r.f[i] = sqrtf(a.f[i])); }
PKTRT__INLINE v8 vfma(v8 a, v8 b, v8 c) { PKTRT__EACH(v8, r.f[i] = a.f[i] * b.f[i] + c.f[i]); }
PKTRT__INLINE v8 vfms(v8 a, v8 b, v8 c) { PKTRT__EACH(v8, r.f[i] = a.f[i] * b.f[i] - c.f[i]); }
PKTRT__INLINE v8 vmin(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] < b.f[i] ? a.f[i] : b.f[i]); }
PKTRT__INLINE v8 vmax(v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = a.f[i] > b.f[i] ? a.f[i] : b.f[i]); }
PKTRT__INLINE v8 vabs(v8 a) { PKTRT__EACH(v8, r.f[i] = fabsf(a.f[i])); }
PKTRT__INLINE v8 vcopysign(v8 magnitude, v8 sign) {
  PKTRT__EACH(v8, r.f[i] = pktrt__sign_bit(sign.f[i]) ? -magnitude.f[i] : magnitude.f[i]);
}
OP uint32_t vsignbits(v8 a) {
  uint32_t r = 0;
  for (int i = 0; i < 8; i++) r |= pktrt__sign_bit(a.f[i]) << i;
  return r;
}
PKTRT__INLINE v8 vswap_halves(v8 a) { PKTRT__EACH(v8, r.f[i] = a.f[i ^ 4]); }
OP float vhmax(v8 a) {
  float r = a.f[0];
  for (int i = 1; i < 8; i++) r = r > a.f[i] ? r : a.f[i];
  return r;
}
#define PKTRT__COMPARE(condition)                        \
  m8 r = 0;                                              \
  for (int i = 0; i < 8; i++) r |= (m8)(condition) << i; \
  return r
OP m8 vlt(v8 a, v8 b) { PKTRT__COMPARE(a.f[i] < b.f[i]); }
OP m8 vle(v8 a, v8 b) { PKTRT__COMPARE(a.f[i] <= b.f[i]); }
OP m8 veq(v8 a, v8 b) { PKTRT__COMPARE(a.f[i] == b.f[i]); }
PKTRT__INLINE m8 mand(m8 a, m8 b) { return a & b; }
PKTRT__INLINE m8 mor(m8 a, m8 b) { return a | b; }
PKTRT__INLINE uint32_t mbits(m8 m) { return m; }
PKTRT__INLINE m8 mfrom(uint32_t bits) { return bits; }
#define PKTRT__TURNS 1u
OP v8 vturn(v8 a, uint32_t turn) { return (void)turn, a; }
OP v8 vload_turn(const float *p, uint32_t turn) { return (void)turn, vload(p); }
OP void vstore_turn(float *p, v8 a) { vstore(p, a); }
OP uint32_t mturn(m8 m) { return mbits(m); }
PKTRT__INLINE v8 vsel(m8 m, v8 a, v8 b) { PKTRT__EACH(v8, r.f[i] = m >> i & 1 ? a.f[i] : b.f[i]); }
OP void vstore_masked(float *p, m8 m, v8 a) {
  for (int i = 0; i < 8; i++)
    if (m >> i & 1) p[i] = a.f[i];
}
OP void vstore_masked_u32(uint32_t *p, m8 m, uint32_t x) {
  for (int i = 0; i < 8; i++)
    if (m >> i & 1) p[i] = x;
}
OP uint32_t veq_u32(const uint32_t *p, uint32_t x) { PKTRT__COMPARE(p[i] == x); }
OP d8 dload(const double *p) { PKTRT__EACH(d8, r.d[i] = p[i]); }
OP void dstore(double *p, d8 a) { memcpy(p, a.d, sizeof a.d); }
OP d8 dsqrt(d8 a) { PKTRT__EACH(d8, r.d[i] = sqrt(a.d[i])); }
OP d8 dfrom(v8 a) { PKTRT__EACH(d8, r.d[i] = (double)a.f[i]); }
OP d8 dset(double x) { PKTRT__EACH(d8, r.d[i] = x); }
OP d8 dadd(d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = a.d[i] + b.d[i]); }
OP d8 dsub(d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = a.d[i] - b.d[i]); }
OP d8 dmul(d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = a.d[i] * b.d[i]); }
PKTRT__DIVIDES_BY_ZERO OP d8 ddiv(d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = a.d[i] / b.d[i]); }
OP d8 dmax(d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = a.d[i] > b.d[i] ? a.d[i] : b.d[i]); }
OP d8 dabs(d8 a) { PKTRT__EACH(d8, r.d[i] = fabs(a.d[i])); }
OP m8 dlt(d8 a, d8 b) { PKTRT__COMPARE(a.d[i] < b.d[i]); }
OP d8 dsel(m8 m, d8 a, d8 b) { PKTRT__EACH(d8, r.d[i] = m >> i & 1 ? a.d[i] : b.d[i]); }
OP v8 dto(d8 a) { PKTRT__EACH(v8, r.f[i] = pktrt__to_float(a.d[i])); }
#undef PKTRT__EACH
#undef PKTRT__COMPARE
#undef OP
#define OP PKTRT__INLINE

#else /* SSE2, NEON and WebAssembly: two registers of 128 bits make a v8 */

#if PKTRT__STAMP == PKTRT__STAMP_SSE2

#define PKTRT__Q(sse2, neon, wasm) sse2
typedef __m128 pktrt__q4;
typedef __m128 pktrt__qm;
typedef __m128d pktrt__q2;
OP pktrt__q4 pktrt__qabs(pktrt__q4 a) { return _mm_andnot_ps(_mm_set1_ps(-0.0f), a); }
OP pktrt__q4 pktrt__qsign(pktrt__q4 a, pktrt__q4 s) { return _mm_or_ps(a, _mm_and_ps(_mm_set1_ps(-0.0f), s)); }
OP pktrt__q4 pktrt__qsel(pktrt__qm m, pktrt__q4 a, pktrt__q4 b) {
  return _mm_or_ps(_mm_and_ps(m, a), _mm_andnot_ps(m, b));
}
OP uint32_t pktrt__qbits(pktrt__qm m) { return (uint32_t)_mm_movemask_ps(m); }
OP pktrt__qm pktrt__qpattern_of(uint32_t x) { return _mm_castsi128_ps(_mm_set1_epi32((int)x)); }
OP void pktrt__qstore(uint32_t *p, pktrt__qm m) { _mm_storeu_si128((__m128i *)(void *)p, _mm_castps_si128(m)); }
OP uint32_t pktrt__qsigns(pktrt__q4 a) { return (uint32_t)_mm_movemask_ps(a); }
OP pktrt__qm pktrt__qfrom(uint32_t bits) {
  const __m128i lane = _mm_setr_epi32(1, 2, 4, 8);
  return _mm_castsi128_ps(_mm_cmpeq_epi32(_mm_and_si128(_mm_set1_epi32((int)bits), lane), lane));
}
OP uint32_t pktrt__qsame(const uint32_t *p, uint32_t x) {
  const __m128i same = _mm_cmpeq_epi32(_mm_loadu_si128((const __m128i *)(const void *)p), _mm_set1_epi32((int)x));
  return (uint32_t)_mm_movemask_ps(_mm_castsi128_ps(same));
}
OP pktrt__q2 pktrt__q2abs(pktrt__q2 a) { return _mm_andnot_pd(_mm_set1_pd(-0.0), a); }
OP pktrt__q2 pktrt__q2high(pktrt__q4 a) { return _mm_cvtps_pd(_mm_movehl_ps(a, a)); }
OP pktrt__q4 pktrt__qfrom2(const pktrt__q2 *q) { return _mm_movelh_ps(_mm_cvtpd_ps(q[0]), _mm_cvtpd_ps(q[1])); }
OP pktrt__qm pktrt__q2lt(const pktrt__q2 *a, const pktrt__q2 *b) {
  const __m128 l = _mm_castpd_ps(_mm_cmplt_pd(a[0], b[0])), h = _mm_castpd_ps(_mm_cmplt_pd(a[1], b[1]));
  return _mm_shuffle_ps(l, h, 0x88);
}
OP pktrt__q2 pktrt__q2sel(pktrt__qm m, const int high, pktrt__q2 a, pktrt__q2 b) {
  const __m128d wide = _mm_castps_pd(high ? _mm_unpackhi_ps(m, m) : _mm_unpacklo_ps(m, m));
  return _mm_or_pd(_mm_and_pd(wide, a), _mm_andnot_pd(wide, b));
}

#elif PKTRT__STAMP == PKTRT__STAMP_NEON /* its min and max treat NaN and zeros differently, hence the selections */

#define PKTRT__Q(sse2, neon, wasm) neon
typedef float32x4_t pktrt__q4;
typedef uint32x4_t pktrt__qm;
typedef float64x2_t pktrt__q2;
OP pktrt__q4 pktrt__qmin(pktrt__q4 a, pktrt__q4 b) { return vbslq_f32(vcltq_f32(a, b), a, b); }
OP pktrt__q4 pktrt__qmax(pktrt__q4 a, pktrt__q4 b) { return vbslq_f32(vcgtq_f32(a, b), a, b); }
OP pktrt__q4 pktrt__qsign(pktrt__q4 a, pktrt__q4 s) { return vbslq_f32(vdupq_n_u32(0x80000000u), s, a); }
OP pktrt__qm pktrt__qlanes(void) {
  const uint32_t lane[4] = {1, 2, 4, 8};
  return vld1q_u32(lane);
}
OP uint32_t pktrt__qbits(pktrt__qm m) { return vaddvq_u32(vandq_u32(m, pktrt__qlanes())); }
OP uint32_t pktrt__qsigns(pktrt__q4 a) { return pktrt__qbits(vcltzq_s32(vreinterpretq_s32_f32(a))); }
OP pktrt__qm pktrt__qfrom(uint32_t bits) { return vtstq_u32(vdupq_n_u32(bits), pktrt__qlanes()); }
OP uint32_t pktrt__qsame(const uint32_t *p, uint32_t x) {
  return pktrt__qbits(vceqq_u32(vld1q_u32(p), vdupq_n_u32(x)));
}
OP pktrt__q2 pktrt__q2max(pktrt__q2 a, pktrt__q2 b) { return vbslq_f64(vcgtq_f64(a, b), a, b); }
OP pktrt__q2 pktrt__q2low(pktrt__q4 a) { return vcvt_f64_f32(vget_low_f32(a)); }
OP pktrt__q4 pktrt__qfrom2(const pktrt__q2 *q) { return vcombine_f32(vcvt_f32_f64(q[0]), vcvt_f32_f64(q[1])); }
OP pktrt__qm pktrt__q2lt(const pktrt__q2 *a, const pktrt__q2 *b) {
  return vcombine_u32(vmovn_u64(vcltq_f64(a[0], b[0])), vmovn_u64(vcltq_f64(a[1], b[1])));
}
OP pktrt__q2 pktrt__q2sel(pktrt__qm m, const int high, pktrt__q2 a, pktrt__q2 b) {
  const int32x4_t wide = vreinterpretq_s32_u32(m);
  return vbslq_f64(vreinterpretq_u64_s64(vmovl_s32(high ? vget_high_s32(wide) : vget_low_s32(wide))), a, b);
}

#else /* WebAssembly; pmin and pmax are those of SSE with swapped operands. Not relaxed: its results differ by machine */

#define PKTRT__Q(sse2, neon, wasm) wasm
typedef v128_t pktrt__q4;
typedef v128_t pktrt__qm;
typedef v128_t pktrt__q2;
OP pktrt__q4 pktrt__qmin(pktrt__q4 a, pktrt__q4 b) { return wasm_f32x4_pmin(b, a); }
OP pktrt__q4 pktrt__qmax(pktrt__q4 a, pktrt__q4 b) { return wasm_f32x4_pmax(b, a); }
OP pktrt__q4 pktrt__qsign(pktrt__q4 a, pktrt__q4 s) { return wasm_v128_bitselect(s, a, wasm_f32x4_splat(-0.0f)); }
OP pktrt__q4 pktrt__qsel(pktrt__qm m, pktrt__q4 a, pktrt__q4 b) { return wasm_v128_bitselect(a, b, m); }
OP uint32_t pktrt__qbits(pktrt__qm m) { return (uint32_t)wasm_i32x4_bitmask(m); }
OP uint32_t pktrt__qsigns(pktrt__q4 a) { return (uint32_t)wasm_i32x4_bitmask(a); }
OP pktrt__qm pktrt__qfrom(uint32_t bits) {
  const v128_t lane = wasm_i32x4_const(1, 2, 4, 8);
  return wasm_i32x4_eq(wasm_v128_and(wasm_i32x4_splat((int)bits), lane), lane);
}
OP uint32_t pktrt__qsame(const uint32_t *p, uint32_t x) {
  return (uint32_t)wasm_i32x4_bitmask(wasm_i32x4_eq(wasm_v128_load(p), wasm_i32x4_splat((int)x)));
}
OP pktrt__q2 pktrt__q2max(pktrt__q2 a, pktrt__q2 b) { return wasm_f64x2_pmax(b, a); }
OP pktrt__q2 pktrt__q2high(pktrt__q4 a) { return wasm_f64x2_promote_low_f32x4(wasm_i64x2_shuffle(a, a, 1, 1)); }
OP pktrt__q4 pktrt__qfrom2(const pktrt__q2 *q) {
  return wasm_i64x2_shuffle(wasm_f32x4_demote_f64x2_zero(q[0]), wasm_f32x4_demote_f64x2_zero(q[1]), 0, 2);
}
OP pktrt__qm pktrt__q2lt(const pktrt__q2 *a, const pktrt__q2 *b) {
  return wasm_i32x4_shuffle(wasm_f64x2_lt(a[0], b[0]), wasm_f64x2_lt(a[1], b[1]), 0, 2, 4, 6);
}
OP pktrt__q2 pktrt__q2sel(pktrt__qm m, const int high, pktrt__q2 a, pktrt__q2 b) {
  return wasm_v128_bitselect(a, b, high ? wasm_i32x4_shuffle(m, m, 2, 2, 3, 3) : wasm_i32x4_shuffle(m, m, 0, 0, 1, 1));
}

#endif

typedef struct v8 {
  pktrt__q4 l, h;
} v8;
typedef struct m8 {
  pktrt__qm l, h;
} m8;
typedef struct d8 {
  pktrt__q2 q[4];
} d8;
#define PKTRT__OF(type, low, high) \
  type r;                          \
  r.l = low, r.h = high;           \
  return r
#define PKTRT__TWO(type, f) PKTRT__OF(type, f(a.l, b.l), f(a.h, b.h))
OP v8 vload(const float *p) {
  PKTRT__OF(v8, PKTRT__Q(_mm_loadu_ps, vld1q_f32, wasm_v128_load)(p),
            PKTRT__Q(_mm_loadu_ps, vld1q_f32, wasm_v128_load)(p + 4));
}
OP void vstore(float *p, v8 a) {
  PKTRT__Q(_mm_storeu_ps, vst1q_f32, wasm_v128_store)(p, a.l);
  PKTRT__Q(_mm_storeu_ps, vst1q_f32, wasm_v128_store)(p + 4, a.h);
}
OP v8 vset(float x) { PKTRT__OF(v8, PKTRT__Q(_mm_set1_ps, vdupq_n_f32, wasm_f32x4_splat)(x), r.l); }
OP v8 vadd(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_add_ps, vaddq_f32, wasm_f32x4_add)); }
OP v8 vsub(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_sub_ps, vsubq_f32, wasm_f32x4_sub)); }
OP v8 vmul(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_mul_ps, vmulq_f32, wasm_f32x4_mul)); }
OP v8 vdiv(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_div_ps, vdivq_f32, wasm_f32x4_div)); }
OP v8 vsqrt(v8 a) {
  PKTRT__OF(v8, PKTRT__Q(_mm_sqrt_ps, vsqrtq_f32, wasm_f32x4_sqrt)(a.l),
            PKTRT__Q(_mm_sqrt_ps, vsqrtq_f32, wasm_f32x4_sqrt)(a.h));
}
OP v8 vfma(v8 a, v8 b, v8 c) { return vadd(vmul(a, b), c); }
OP v8 vfms(v8 a, v8 b, v8 c) { return vsub(vmul(a, b), c); }
OP v8 vmin(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_min_ps, pktrt__qmin, pktrt__qmin)); }
OP v8 vmax(v8 a, v8 b) { PKTRT__TWO(v8, PKTRT__Q(_mm_max_ps, pktrt__qmax, pktrt__qmax)); }
OP v8 vabs(v8 a) {
  PKTRT__OF(v8, PKTRT__Q(pktrt__qabs, vabsq_f32, wasm_f32x4_abs)(a.l),
            PKTRT__Q(pktrt__qabs, vabsq_f32, wasm_f32x4_abs)(a.h));
}
OP v8 vcopysign(v8 a, v8 b) { PKTRT__TWO(v8, pktrt__qsign); }
OP uint32_t vsignbits(v8 a) { return pktrt__qsigns(a.l) | pktrt__qsigns(a.h) << 4; }
OP m8 vlt(v8 a, v8 b) { PKTRT__TWO(m8, PKTRT__Q(_mm_cmplt_ps, vcltq_f32, wasm_f32x4_lt)); }
OP m8 vle(v8 a, v8 b) { PKTRT__TWO(m8, PKTRT__Q(_mm_cmple_ps, vcleq_f32, wasm_f32x4_le)); }
OP m8 veq(v8 a, v8 b) { PKTRT__TWO(m8, PKTRT__Q(_mm_cmpeq_ps, vceqq_f32, wasm_f32x4_eq)); }
OP m8 mand(m8 a, m8 b) { PKTRT__TWO(m8, PKTRT__Q(_mm_and_ps, vandq_u32, wasm_v128_and)); }
OP m8 mor(m8 a, m8 b) { PKTRT__TWO(m8, PKTRT__Q(_mm_or_ps, vorrq_u32, wasm_v128_or)); }
OP uint32_t mbits(m8 m) { return pktrt__qbits(m.l) | pktrt__qbits(m.h) << 4; }
OP m8 mfrom(uint32_t bits) { PKTRT__OF(m8, pktrt__qfrom(bits), pktrt__qfrom(bits >> 4)); }
#define PKTRT__TURNS 2u /* in which blocks are met and few lanes worked on: half a vector each */
OP v8 vload_turn(const float *p, uint32_t turn) {
  PKTRT__OF(v8, PKTRT__Q(_mm_loadu_ps, vld1q_f32, wasm_v128_load)(p + 4 * turn), r.l);
}
OP v8 vturn(v8 a, uint32_t turn) { PKTRT__OF(v8, turn ? a.h : a.l, r.l); }
OP void vstore_turn(float *p, v8 a) { PKTRT__Q(_mm_storeu_ps, vst1q_f32, wasm_v128_store)(p, a.l); }
OP uint32_t mturn(m8 m) { return pktrt__qbits(m.l); }
OP v8 vswap_halves(v8 a) { PKTRT__OF(v8, a.h, a.l); }
OP v8 vsel(m8 m, v8 a, v8 b) {
  PKTRT__OF(v8, PKTRT__Q(pktrt__qsel, vbslq_f32, pktrt__qsel)(m.l, a.l, b.l),
            PKTRT__Q(pktrt__qsel, vbslq_f32, pktrt__qsel)(m.h, a.h, b.h));
}
OP void vstore_masked(float *p, m8 m, v8 a) { vstore(p, vsel(m, a, vload(p))); }
OP void vstore_masked_u32(uint32_t *p, m8 m, uint32_t x) {
  for (uint32_t bits = mbits(m); bits; bits &= bits - 1) p[pktrt__lowest_bit(bits)] = x;
}
OP uint32_t veq_u32(const uint32_t *p, uint32_t x) { return pktrt__qsame(p, x) | pktrt__qsame(p + 4, x) << 4; }
OP float vhmax(v8 a) {
  float f[4], r;
  PKTRT__Q(_mm_storeu_ps, vst1q_f32, wasm_v128_store)(f, PKTRT__Q(_mm_max_ps, pktrt__qmax, pktrt__qmax)(a.l, a.h));
  r = f[0];
  for (int i = 1; i < 4; i++) r = r > f[i] ? r : f[i];
  return r;
}
#define PKTRT__EACH(expression)                           \
  d8 r;                                                   \
  UNROLL for (int i = 0; i < 4; i++) r.q[i] = expression; \
  return r
OP d8 dfrom(v8 a) {
  d8 r;
  r.q[0] = PKTRT__Q(_mm_cvtps_pd, pktrt__q2low, wasm_f64x2_promote_low_f32x4)(a.l),
  r.q[1] = PKTRT__Q(pktrt__q2high, vcvt_high_f64_f32, pktrt__q2high)(a.l);
  r.q[2] = PKTRT__Q(_mm_cvtps_pd, pktrt__q2low, wasm_f64x2_promote_low_f32x4)(a.h),
  r.q[3] = PKTRT__Q(pktrt__q2high, vcvt_high_f64_f32, pktrt__q2high)(a.h);
  return r;
}
OP d8 dload(const double *p) { PKTRT__EACH(PKTRT__Q(_mm_loadu_pd, vld1q_f64, wasm_v128_load)(p + 2 * i)); }
OP void dstore(double *p, d8 a) {
  UNROLL for (int i = 0; i < 4; i++) PKTRT__Q(_mm_storeu_pd, vst1q_f64, wasm_v128_store)(p + 2 * i, a.q[i]);
}
OP d8 dsqrt(d8 a) { PKTRT__EACH(PKTRT__Q(_mm_sqrt_pd, vsqrtq_f64, wasm_f64x2_sqrt)(a.q[i])); }
OP d8 dset(double x) { PKTRT__EACH(PKTRT__Q(_mm_set1_pd, vdupq_n_f64, wasm_f64x2_splat)(x)); }
OP d8 dadd(d8 a, d8 b) { PKTRT__EACH(PKTRT__Q(_mm_add_pd, vaddq_f64, wasm_f64x2_add)(a.q[i], b.q[i])); }
OP d8 dsub(d8 a, d8 b) { PKTRT__EACH(PKTRT__Q(_mm_sub_pd, vsubq_f64, wasm_f64x2_sub)(a.q[i], b.q[i])); }
OP d8 dmul(d8 a, d8 b) { PKTRT__EACH(PKTRT__Q(_mm_mul_pd, vmulq_f64, wasm_f64x2_mul)(a.q[i], b.q[i])); }
OP d8 ddiv(d8 a, d8 b) { PKTRT__EACH(PKTRT__Q(_mm_div_pd, vdivq_f64, wasm_f64x2_div)(a.q[i], b.q[i])); }
OP d8 dmax(d8 a, d8 b) { PKTRT__EACH(PKTRT__Q(_mm_max_pd, pktrt__q2max, pktrt__q2max)(a.q[i], b.q[i])); }
OP d8 dabs(d8 a) { PKTRT__EACH(PKTRT__Q(pktrt__q2abs, vabsq_f64, wasm_f64x2_abs)(a.q[i])); }
OP m8 dlt(d8 a, d8 b) { PKTRT__OF(m8, pktrt__q2lt(a.q, b.q), pktrt__q2lt(a.q + 2, b.q + 2)); }
OP d8 dsel(m8 m, d8 a, d8 b) { PKTRT__EACH(pktrt__q2sel(i < 2 ? m.l : m.h, i % 2, a.q[i], b.q[i])); }
OP v8 dto(d8 a) { PKTRT__OF(v8, pktrt__qfrom2(a.q), pktrt__qfrom2(a.q + 2)); }

typedef struct a8 { /* eight ray masks, one per child: low halves, high halves */
  m8 l, h;
} a8;
OP m8 pktrt__qpattern(uint32_t x) {
  PKTRT__OF(m8, PKTRT__Q(pktrt__qpattern_of, vdupq_n_u32, wasm_u32x4_splat)(x), r.l);
}
OP a8 azero(void) { PKTRT__OF(a8, pktrt__qpattern(0), r.l); }
OP a8 aor(a8 a, m8 m, uint32_t bit) {
  PKTRT__OF(a8, mor(a.l, mand(m, pktrt__qpattern(pktrt__mask_halves(bit)[32]))),
            mor(a.h, mand(m, pktrt__qpattern(pktrt__mask_halves(bit)[0]))));
}
OP uint32_t apush(a8 a, const uint32_t *child, v8 dist, uint32_t perm, uint64_t *masks, uint32_t *refs, float *nears) {
  float near_w[8];
  uint32_t l[8], h[8];
  uint64_t mask[8];
  vstore(near_w, dist);
  for (int i = 0; i < 2; i++) {
    PKTRT__Q(pktrt__qstore, vst1q_u32, wasm_v128_store)(l + 4 * i, i ? a.l.h : a.l.l);
    PKTRT__Q(pktrt__qstore, vst1q_u32, wasm_v128_store)(h + 4 * i, i ? a.h.h : a.h.l);
  }
  for (int i = 0; i < 8; i++) mask[i] = (uint64_t)h[i] << 32 | l[i];
  return pktrt__stream_push_children(mask, child, near_w, perm, masks, refs, nears);
}
#undef PKTRT__EACH
#undef PKTRT__TWO
#undef PKTRT__OF
#undef PKTRT__Q

#endif

#if (PKTRT__STAMP != PKTRT__STAMP_AVX2 && PKTRT__STAMP != PKTRT__STAMP_AVX512) || !defined(__x86_64__)
OP uint64_t vorder_children(uint32_t keep, uint32_t perm) {
  uint64_t all = 0;
  for (uint32_t i = 0, n = 0; i < 8; i++, perm >>= 3) {
    const uint32_t kept = keep >> (perm & 7) & 1;
    all |= (uint64_t)(perm & 7 & (0u - kept)) << 8 * n;
    n += kept;
  }
  return all;
}
#endif
OP float vhmin(v8 a) { return -vhmax(vmul(a, vset(-1))); }
/* Returns the largest absolute value of two, and of three. */
OP v8 vmax_abs(v8 a, v8 b) {
#if PKTRT__STAMP == PKTRT__STAMP_AVX512
  return _mm256_range_ps(a, b, 0xB);
#else
  return vmax(vabs(a), vabs(b));
#endif
}
OP v8 vmax_abs3(v8 a, v8 b, v8 c) {
#if PKTRT__STAMP == PKTRT__STAMP_AVX512
  return vmax_abs(vmax_abs(a, b), c);
#elif PKTRT__STAMP == PKTRT__STAMP_SCALAR
  v8 r; /* in one go */
  for (int i = 0; i < 8; i++) r.f[i] = pktrt__maxf(fabsf(a.f[i]), pktrt__maxf(fabsf(b.f[i]), fabsf(c.f[i])));
  return r;
#else
  return vmax(vabs(a), vmax_abs(b, c));
#endif
}
/* Turns bit j of a number into byte j, 0 or 1, for its lowest eight bits. */
OP uint64_t vbytes(uint32_t bits) {
#if (PKTRT__STAMP == PKTRT__STAMP_AVX512 || PKTRT__STAMP == PKTRT__STAMP_AVX2) && \
    (defined(__x86_64__) || defined(_M_X64))
  return _pdep_u64(bits, UINT64_C(0x0101010101010101));
#else
  const uint64_t all = (bits & 0xFF) * UINT64_C(0x0101010101010101), each = all & UINT64_C(0x8040201008040201);
  return (each + UINT64_C(0x7F7F7F7F7F7F7F7F)) >> 7 & UINT64_C(0x0101010101010101); /* a bit that is set carries */
#endif
}
/* Stores eight bytes; bits 0, 1, 2 of byte j are bit j of the three numbers. */
OP void vstore_bytes(uint8_t *to, uint32_t bit0, uint32_t bit1, uint32_t bit2) {
  pktrt__store_bytes(to, vbytes(bit0) | vbytes(bit1) << 1 | vbytes(bit2) << 2);
}
/* Returns which of 64 bytes equal x. */
OP uint64_t veq_u8x64(const uint8_t *p, uint8_t x) {
#if PKTRT__STAMP == PKTRT__STAMP_AVX512
  return _mm512_cmpeq_epi8_mask(_mm512_loadu_si512(p), _mm512_set1_epi8((char)x));
#elif PKTRT__STAMP == PKTRT__STAMP_AVX2 || PKTRT__STAMP == PKTRT__STAMP_SSE2
  uint64_t same = 0;
  UNROLL for (int i = 0; i < 4; i++) {
    const __m128i all = _mm_loadu_si128((const __m128i *)(const void *)(p + 16 * i));
    same |= (uint64_t)(uint32_t)_mm_movemask_epi8(_mm_cmpeq_epi8(all, _mm_set1_epi8((char)x))) << 16 * i;
  }
  return same;
#else
  uint64_t same = 0;
  for (int i = 0; i < 64; i++) same |= (uint64_t)(p[i] == x) << i;
  return same;
#endif
}
#if PKTRT__STAMP == PKTRT__STAMP_AVX2
typedef struct a8 { /* eight ray masks, one per child: low halves, high halves */
  __m256i l, h;
} a8;
OP a8 azero(void) {
  a8 r;
  r.l = r.h = _mm256_setzero_si256();
  return r;
}
OP a8 aor(a8 a, m8 m, uint32_t bit) {
  const __m256i i = _mm256_castps_si256(m);
  a.l = _mm256_or_si256(a.l, _mm256_and_si256(i, _mm256_set1_epi32((int)pktrt__mask_halves(bit)[32])));
  a.h = _mm256_or_si256(a.h, _mm256_and_si256(i, _mm256_set1_epi32((int)pktrt__mask_halves(bit)[0])));
  return a;
}
OP uint32_t apush(a8 a, const uint32_t *child, v8 dist, uint32_t perm, uint64_t *masks, uint32_t *refs, float *nears) {
  const __m256i none = _mm256_cmpeq_epi32(_mm256_or_si256(a.l, a.h), _mm256_setzero_si256());
  const uint32_t some = 0xFFu & ~mbits(_mm256_castsi256_ps(none));
  const uint64_t bytes = vorder_children(some, perm);
  const __m256i order = _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i *)(const void *)&bytes));
  const __m256i c = _mm256_permutevar8x32_epi32(_mm256_loadu_si256((const __m256i *)(const void *)child), order);
  const __m256i l = _mm256_permutevar8x32_epi32(a.l, order), h = _mm256_permutevar8x32_epi32(a.h, order);
  const __m256i m0145 = _mm256_unpacklo_epi32(l, h), m2367 = _mm256_unpackhi_epi32(l, h);
  _mm256_storeu_si256((__m256i *)(void *)masks, _mm256_permute2x128_si256(m0145, m2367, 0x20));
  _mm256_storeu_si256((__m256i *)(void *)(masks + 4), _mm256_permute2x128_si256(m0145, m2367, 0x31));
  _mm256_storeu_si256((__m256i *)(void *)refs, c);
  _mm256_storeu_ps(nears, _mm256_permutevar8x32_ps(dist, order));
  return pktrt__popcount(some);
}
#elif PKTRT__STAMP == PKTRT__STAMP_SCALAR
typedef struct a8 { /* eight ray masks, one per child */
  uint64_t mask[8];
} a8;
OP a8 azero(void) {
  a8 r;
  memset(&r, 0, sizeof r);
  return r;
}
OP a8 aor(a8 a, m8 m, uint32_t bit) {
  const uint32_t bits = mbits(m);
  for (int i = 0; i < 8; i++) a.mask[i] |= (uint64_t)(bits >> i & 1) << bit;
  return a;
}
OP uint32_t apush(a8 a, const uint32_t *child, v8 dist, uint32_t perm, uint64_t *masks, uint32_t *refs, float *nears) {
  float near_w[8];
  vstore(near_w, dist);
  return pktrt__stream_push_children(a.mask, child, near_w, perm, masks, refs, nears);
}
#endif

#if PKTRT__STAMP == PKTRT__STAMP_AVX2 && (defined(__x86_64__) || defined(_M_X64))
typedef __m256i c8;
OP c8 vchoose(uint32_t lanes) {
  const uint64_t bytes = _pdep_u64(lanes, 0x0101010101010101u) * 0xFF, order = _pext_u64(0x0706050403020100u, bytes);
  return _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((long long)order));
}
OP void vcompress(float *p, c8 order, v8 a) { vstore(p, _mm256_permutevar8x32_ps(a, order)); }
OP void vcompress_from(void *p, c8 order, const void *from) { /* bits are kept */
  vcompress(PKTRT__CAST(float *, p), order, vload(PKTRT__CAST(const float *, from)));
}
#elif PKTRT__STAMP != PKTRT__STAMP_AVX512
typedef uint32_t c8;
OP c8 vchoose(uint32_t lanes) { return lanes; }
PKTRT__NOINLINE void vcompress(float *p, c8 lanes, v8 a) {
  float f[8];
  vstore(lanes == 0xFF ? p : f, a);
  for (uint32_t i = 0; lanes != 0xFF && lanes; lanes &= lanes - 1) p[i++] = f[pktrt__lowest_bit(lanes)];
}
PKTRT__NOINLINE void vcompress_from(void *p, c8 lanes, const void *from) {
  for (char *to = PKTRT__CAST(char *, p); lanes; lanes &= lanes - 1, to += 4)
    memmove(to, PKTRT__CAST(const char *, from) + 4 * pktrt__lowest_bit(lanes), 4);
}
#endif

/* The wide vector of frustum packets. */
#if PKTRT__STAMP == PKTRT__STAMP_AVX512
#define FW 16
#define UNROLL_WIDE UNROLL /* loops over a packet: four vectors */
#define vf PKTRT__NAME(pktrt__vf)
#define mf PKTRT__NAME(pktrt__mf)
typedef __m512 vf;
typedef __mmask16 mf;
#define fload(p) _mm512_loadu_ps(p)
#define fstore(p, a) _mm512_storeu_ps(p, a)
#define fset(x) _mm512_set1_ps(x)
#define fwide(a) _mm512_castps256_ps512(a) /* widens a v8; the upper lanes are undefined */
#define fadd(a, b) _mm512_add_ps(a, b)
#define fsub(a, b) _mm512_sub_ps(a, b)
#define fmul(a, b) _mm512_mul_ps(a, b)
#define fdiv(a, b) _mm512_div_ps(a, b)
#define ffma(a, b, c) _mm512_fmadd_ps(a, b, c)
#define ffms(a, b, c) _mm512_fmsub_ps(a, b, c)
#define fmin_(a, b) _mm512_min_ps(a, b)
#define fmax_(a, b) _mm512_max_ps(a, b)
#define fabs_(a) _mm512_abs_ps(a)
#define fsel(m, a, b) _mm512_mask_blend_ps(m, b, a)
#define fmin_masked(m, a, b) _mm512_mask_min_ps(a, m, a, b) /* the smaller, where m; else a */
#define fmax_masked(m, a, b) _mm512_mask_max_ps(a, m, a, b)
#define fle(a, b) _mm512_cmp_ps_mask(a, b, _CMP_LE_OQ)
#define flt(a, b) _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ)
#define feq(a, b) _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ)
#define fmand(a, b) (mf)((a) & (b))
#define fmor(a, b) (mf)((a) | (b))
#define fbits(m) (uint32_t)(m)
#define ffrom(bits) (mf)(bits)
#define fhmin(a) _mm512_reduce_min_ps(a)
#define fhmax(a) _mm512_reduce_max_ps(a)
#define fsignbits(a) (uint32_t) _mm512_movepi32_mask(_mm512_castps_si512(a))
#define fcopysign(magnitude, sign) _mm512_or_ps(magnitude, _mm512_and_ps(sign, _mm512_set1_ps(-0.0f)))
#define fstore_masked(p, m, a) _mm512_mask_storeu_ps(p, m, a)
#define fstore_masked_u32(p, m, x) _mm512_mask_storeu_epi32(p, m, _mm512_set1_epi32((int)(x)))
#else
#define FW 8
#define UNROLL_WIDE
#define vf v8
#define mf m8
#define fload vload
#define fstore vstore
#define fset vset
#define fwide(a) (a)
#define fadd vadd
#define fsub vsub
#define fmul vmul
#define fdiv vdiv
#define ffma vfma
#define ffms vfms
#define fmin_ vmin
#define fmax_ vmax
#define fabs_ vabs
#define fsel vsel
#define fmin_masked(m, a, b) vmin(a, vsel(m, b, a))
#define fmax_masked(m, a, b) vmax(a, vsel(m, b, a))
#define fle vle
#define flt vlt
#define feq veq
#define fmand mand
#define fmor mor
#define fbits mbits
#define ffrom mfrom
#define fhmin vhmin
#define fhmax vhmax
#define fsignbits vsignbits
#define fcopysign vcopysign
#define fstore_masked vstore_masked
#define fstore_masked_u32 vstore_masked_u32
#endif

/* >>names -----------------------------------------------------------------------------------------------------------

   A kernel is written once under one name, which stands for one function of each instruction set: pktrt__box_test_rays
   for pktrt__box_test_rays_avx2 and so on. Tags and editors find the short name, a debugger the full name. */

#define pktrt__batch_load_rays PKTRT__NAME(pktrt__batch_load_rays)
#define pktrt__batch_packet_time_weights PKTRT__NAME(pktrt__batch_packet_time_weights)
#define pktrt__batch_setup PKTRT__NAME(pktrt__batch_setup)
#define pktrt__batch_store_hits PKTRT__NAME(pktrt__batch_store_hits)
#define pktrt__batch_copy_row PKTRT__NAME(pktrt__batch_copy_row)
#define pktrt__batch_name_hits PKTRT__NAME(pktrt__batch_name_hits)
#define pktrt__batch_store_names PKTRT__NAME(pktrt__batch_store_names)
#define pktrt__batch_store_occluded PKTRT__NAME(pktrt__batch_store_occluded)
#define pktrt__batch_time_weights PKTRT__NAME(pktrt__batch_time_weights)
#define pktrt__box_load_slabs PKTRT__NAME(pktrt__box_load_slabs)
#define pktrt__box_slabs PKTRT__NAME(pktrt__box_slabs)
#define pktrt__box_test_children PKTRT__NAME(pktrt__box_test_children)
#define pktrt__box_test_packet PKTRT__NAME(pktrt__box_test_packet)
#define pktrt__box_test_rays PKTRT__NAME(pktrt__box_test_rays)
#define pktrt__bvh_child_count PKTRT__NAME(pktrt__bvh_child_count)
#define pktrt__bvh_children PKTRT__NAME(pktrt__bvh_children)
#define pktrt__camera_rays8 PKTRT__NAME(pktrt__camera_rays8)
#define pktrt__check_all PKTRT__NAME(pktrt__check_all)
#define pktrt__check_arithmetic PKTRT__NAME(pktrt__check_arithmetic)
#define pktrt__check_value PKTRT__NAME(pktrt__check_value)
#define pktrt__drive_batch_ray PKTRT__NAME(pktrt__drive_batch_ray)
#define pktrt__drive_fast PKTRT__NAME(pktrt__drive_fast)
#define pktrt__drive_find_moving PKTRT__NAME(pktrt__drive_find_moving)
#define pktrt__drive_frustum PKTRT__NAME(pktrt__drive_frustum)
#define pktrt__drive_is_coherent PKTRT__NAME(pktrt__drive_is_coherent)
#define pktrt__drive_may_meet PKTRT__NAME(pktrt__drive_may_meet)
#define pktrt__drive_next_packet PKTRT__NAME(pktrt__drive_next_packet)
#define pktrt__drive_octants PKTRT__NAME(pktrt__drive_octants)
#define pktrt__drive_rays_alike PKTRT__NAME(pktrt__drive_rays_alike)
#define pktrt__drive_rays_along PKTRT__NAME(pktrt__drive_rays_along)
#define pktrt__drive_rays_near PKTRT__NAME(pktrt__drive_rays_near)
#define pktrt__drive_rays_of_segment PKTRT__NAME(pktrt__drive_rays_of_segment)
#define pktrt__drive_single PKTRT__NAME(pktrt__drive_single)
#define pktrt__drive_single_in PKTRT__NAME(pktrt__drive_single_in)
#define pktrt__drive_stream PKTRT__NAME(pktrt__drive_stream)
#define pktrt__drive_stream_in PKTRT__NAME(pktrt__drive_stream_in)
#define pktrt__entry_intersect PKTRT__NAME(pktrt__entry_intersect)
#define pktrt__entry_occluded PKTRT__NAME(pktrt__entry_occluded)
#define pktrt__entry_single PKTRT__NAME(pktrt__entry_single)
#define pktrt__entry_trace PKTRT__NAME(pktrt__entry_trace)
#define pktrt__exact_calm8 PKTRT__NAME(pktrt__exact_calm8)
#define pktrt__exact_edge_functions8 PKTRT__NAME(pktrt__exact_edge_functions8)
#define pktrt__exact_edges8 PKTRT__NAME(pktrt__exact_edges8)
#define pktrt__exact_shear8 PKTRT__NAME(pktrt__exact_shear8)
#define pktrt__fit_children PKTRT__NAME(pktrt__fit_children)
#define pktrt__fit_kernels PKTRT__NAME(pktrt__fit_kernels)
#define pktrt__fit_lanes_with_area PKTRT__NAME(pktrt__fit_lanes_with_area)
#define pktrt__fit_nodes PKTRT__NAME(pktrt__fit_nodes)
#define pktrt__frustum_accept PKTRT__NAME(pktrt__frustum_accept)
#define pktrt__frustum_apart8 PKTRT__NAME(pktrt__frustum_apart8)
#define pktrt__frustum_common_origin PKTRT__NAME(pktrt__frustum_common_origin)
#define pktrt__frustum_corners PKTRT__NAME(pktrt__frustum_corners)
#define pktrt__frustum_crossed PKTRT__NAME(pktrt__frustum_crossed)
#define pktrt__frustum_cull_by_edges PKTRT__NAME(pktrt__frustum_cull_by_edges)
#define pktrt__frustum_cull_children PKTRT__NAME(pktrt__frustum_cull_children)
#define pktrt__frustum_cull_children_moving PKTRT__NAME(pktrt__frustum_cull_children_moving)
#define pktrt__frustum_cull_moving PKTRT__NAME(pktrt__frustum_cull_moving)
#define pktrt__frustum_cull_triangles PKTRT__NAME(pktrt__frustum_cull_triangles)
#define pktrt__frustum_edges PKTRT__NAME(pktrt__frustum_edges)
#define pktrt__frustum_entry PKTRT__NAME(pktrt__frustum_entry)
#define pktrt__frustum_exact8 PKTRT__NAME(pktrt__frustum_exact8)
#define pktrt__frustum_exact_test8 PKTRT__NAME(pktrt__frustum_exact_test8)
#define pktrt__frustum_filter_resting PKTRT__NAME(pktrt__frustum_filter_resting)
#define pktrt__frustum_nearer8 PKTRT__NAME(pktrt__frustum_nearer8)
#define pktrt__frustum_plane8 PKTRT__NAME(pktrt__frustum_plane8)
#define pktrt__frustum_plane_of PKTRT__NAME(pktrt__frustum_plane_of)
#define pktrt__frustum_see8 PKTRT__NAME(pktrt__frustum_see8)
#define pktrt__frustum_see_rays8 PKTRT__NAME(pktrt__frustum_see_rays8)
#define pktrt__frustum_shear PKTRT__NAME(pktrt__frustum_shear)
#define pktrt__frustum_solve8 PKTRT__NAME(pktrt__frustum_solve8)
#define pktrt__frustum_view8 PKTRT__NAME(pktrt__frustum_view8)
#define pktrt__frustum_filter PKTRT__NAME(pktrt__frustum_filter)
#define pktrt__frustum_filter_moving PKTRT__NAME(pktrt__frustum_filter_moving)
#define pktrt__frustum_is_thin PKTRT__NAME(pktrt__frustum_is_thin)
#define pktrt__frustum_leaf PKTRT__NAME(pktrt__frustum_leaf)
#define pktrt__frustum_leaf_moving PKTRT__NAME(pktrt__frustum_leaf_moving)
#define pktrt__frustum_motion PKTRT__NAME(pktrt__frustum_motion)
#define pktrt__frustum_open_node PKTRT__NAME(pktrt__frustum_open_node)
#define pktrt__frustum_origins PKTRT__NAME(pktrt__frustum_origins)
#define pktrt__frustum_planes PKTRT__NAME(pktrt__frustum_planes)
#define pktrt__frustum_reach PKTRT__NAME(pktrt__frustum_reach)
#define pktrt__frustum_reach_add PKTRT__NAME(pktrt__frustum_reach_add)
#define pktrt__frustum_reach_inside PKTRT__NAME(pktrt__frustum_reach_inside)
#define pktrt__frustum_reach_none PKTRT__NAME(pktrt__frustum_reach_none)
#define pktrt__frustum_reach_size PKTRT__NAME(pktrt__frustum_reach_size)
#define pktrt__frustum_set_hits PKTRT__NAME(pktrt__frustum_set_hits)
#define pktrt__frustum_setup PKTRT__NAME(pktrt__frustum_setup)
#define pktrt__frustum_swept_plane PKTRT__NAME(pktrt__frustum_swept_plane)
#define pktrt__frustum_template PKTRT__NAME(pktrt__frustum_template)
#define pktrt__frustum_test_child PKTRT__NAME(pktrt__frustum_test_child)
#define pktrt__frustum_test_child_from PKTRT__NAME(pktrt__frustum_test_child_from)
#define pktrt__frustum_test_child_template PKTRT__NAME(pktrt__frustum_test_child_template)
#define pktrt__frustum_test_child_moving PKTRT__NAME(pktrt__frustum_test_child_moving)
#define pktrt__frustum_test_moving PKTRT__NAME(pktrt__frustum_test_moving)
#define pktrt__frustum_test_triangle PKTRT__NAME(pktrt__frustum_test_triangle)
#define pktrt__frustum_times PKTRT__NAME(pktrt__frustum_times)
#define pktrt__frustum_traverse PKTRT__NAME(pktrt__frustum_traverse)
#define pktrt__frustum_update_depth PKTRT__NAME(pktrt__frustum_update_depth)
#define pktrt__glass_clip PKTRT__NAME(pktrt__glass_clip)
#define pktrt__glass_find_rays PKTRT__NAME(pktrt__glass_find_rays)
#define pktrt__kernels PKTRT__NAME(pktrt__kernels)
#define pktrt__lanes_first PKTRT__NAME(pktrt__lanes_first)
#define pktrt__lanes_occupied PKTRT__NAME(pktrt__lanes_occupied)
#define pktrt__lanes_unhit PKTRT__NAME(pktrt__lanes_unhit)
#define pktrt__light_add PKTRT__NAME(pktrt__light_add)
#define pktrt__light_locate PKTRT__NAME(pktrt__light_locate)
#define pktrt__light_sample_all PKTRT__NAME(pktrt__light_sample_all)
#define pktrt__light_sample_quad8 PKTRT__NAME(pktrt__light_sample_quad8)
#define pktrt__light_sample_sky8 PKTRT__NAME(pktrt__light_sample_sky8)
#define pktrt__light_sample_sphere8 PKTRT__NAME(pktrt__light_sample_sphere8)
#define pktrt__light_shadow_rays PKTRT__NAME(pktrt__light_shadow_rays)
#define pktrt__light_shadow_rays8 PKTRT__NAME(pktrt__light_shadow_rays8)
#define pktrt__light_visibility PKTRT__NAME(pktrt__light_visibility)
#define pktrt__material_cosine_behind PKTRT__NAME(pktrt__material_cosine_behind)
#define pktrt__material_evaluate PKTRT__NAME(pktrt__material_evaluate)
#define pktrt__material_scatter PKTRT__NAME(pktrt__material_scatter)
#define pktrt__material_weights8 PKTRT__NAME(pktrt__material_weights8)
#define pktrt__paper_accept8 PKTRT__NAME(pktrt__paper_accept8)
#define pktrt__paper_active PKTRT__NAME(pktrt__paper_active)
#define pktrt__paper_box PKTRT__NAME(pktrt__paper_box)
#define pktrt__paper_child PKTRT__NAME(pktrt__paper_child)
#define pktrt__paper_child_of PKTRT__NAME(pktrt__paper_child_of)
#define pktrt__paper_event PKTRT__NAME(pktrt__paper_event)
#define pktrt__paper_find_first PKTRT__NAME(pktrt__paper_find_first)
#define pktrt__paper_frustum_misses PKTRT__NAME(pktrt__paper_frustum_misses)
#define pktrt__paper_interval_misses PKTRT__NAME(pktrt__paper_interval_misses)
#define pktrt__paper_intervals PKTRT__NAME(pktrt__paper_intervals)
#define pktrt__paper_leaf PKTRT__NAME(pktrt__paper_leaf)
#define pktrt__paper_packet PKTRT__NAME(pktrt__paper_packet)
#define pktrt__paper_tell PKTRT__NAME(pktrt__paper_tell)
#define pktrt__paper_test_group PKTRT__NAME(pktrt__paper_test_group)
#define pktrt__paper_test_triangle PKTRT__NAME(pktrt__paper_test_triangle)
#define pktrt__paper_traverse PKTRT__NAME(pktrt__paper_traverse)
#define pktrt__paper_traverse_any PKTRT__NAME(pktrt__paper_traverse_any)
#define pktrt__paper_trim PKTRT__NAME(pktrt__paper_trim)
#define pktrt__paper_update_depth PKTRT__NAME(pktrt__paper_update_depth)
#define pktrt__place_between8 PKTRT__NAME(pktrt__place_between8)
#define pktrt__place_cross PKTRT__NAME(pktrt__place_cross)
#define pktrt__place_frame PKTRT__NAME(pktrt__place_frame)
#define pktrt__place_load PKTRT__NAME(pktrt__place_load)
#define pktrt__place_load8 PKTRT__NAME(pktrt__place_load8)
#define pktrt__place_load_between PKTRT__NAME(pktrt__place_load_between)
#define pktrt__place_ray_within PKTRT__NAME(pktrt__place_ray_within)
#define pktrt__place_copy_row PKTRT__NAME(pktrt__place_copy_row)
#define pktrt__place_rays PKTRT__NAME(pktrt__place_rays)
#define pktrt__place_ray8 PKTRT__NAME(pktrt__place_ray8)
#define pktrt__place_rays8 PKTRT__NAME(pktrt__place_rays8)
#define pktrt__place_slabs PKTRT__NAME(pktrt__place_slabs)
#define pktrt__place_test_boxes PKTRT__NAME(pktrt__place_test_boxes)
#define pktrt__place_trace PKTRT__NAME(pktrt__place_trace)
#define pktrt__place_enter PKTRT__NAME(pktrt__place_enter)
#define pktrt__place_packet PKTRT__NAME(pktrt__place_packet)
#define pktrt__place_frustum PKTRT__NAME(pktrt__place_frustum)
#define pktrt__place_frustum_leaf PKTRT__NAME(pktrt__place_frustum_leaf)
#define pktrt__drive_mark PKTRT__NAME(pktrt__drive_mark)
#define pktrt__place_leaf PKTRT__NAME(pktrt__place_leaf)
#define pktrt__place_load_slabs PKTRT__NAME(pktrt__place_load_slabs)
#define pktrt__place_stream_in PKTRT__NAME(pktrt__place_stream_in)
#define pktrt__place_stream_template PKTRT__NAME(pktrt__place_stream_template)
#define pktrt__place_stream PKTRT__NAME(pktrt__place_stream)
#define pktrt__place_packets PKTRT__NAME(pktrt__place_packets)
#define pktrt__place_matrix8 PKTRT__NAME(pktrt__place_matrix8)
#define pktrt__place_resolve8 PKTRT__NAME(pktrt__place_resolve8)
#define pktrt__place_turn8 PKTRT__NAME(pktrt__place_turn8)
#define pktrt__place_turn_edges8 PKTRT__NAME(pktrt__place_turn_edges8)
#define pktrt__place_trace_few PKTRT__NAME(pktrt__place_trace_few)
#define pktrt__place_trace_single PKTRT__NAME(pktrt__place_trace_single)
#define pktrt__place_single_in PKTRT__NAME(pktrt__place_single_in)
#define pktrt__place_single PKTRT__NAME(pktrt__place_single)
#define pktrt__resolve_axes PKTRT__NAME(pktrt__resolve_axes)
#define pktrt__resolve_batch PKTRT__NAME(pktrt__resolve_batch)
#define pktrt__resolve_gather_corners PKTRT__NAME(pktrt__resolve_gather_corners)
#define pktrt__resolve_hits PKTRT__NAME(pktrt__resolve_hits)
#define pktrt__resolve_misses PKTRT__NAME(pktrt__resolve_misses)
#define pktrt__resolve_turn PKTRT__NAME(pktrt__resolve_turn)
#define pktrt__sampler_draw PKTRT__NAME(pktrt__sampler_draw)
#define pktrt__sampler_scramble_rows PKTRT__NAME(pktrt__sampler_scramble_rows)
#define pktrt__sampler_second_pairs PKTRT__NAME(pktrt__sampler_second_pairs)
#define pktrt__sampler_shuffle PKTRT__NAME(pktrt__sampler_shuffle)
#define pktrt__sampler_split_halves PKTRT__NAME(pktrt__sampler_split_halves)
#define pktrt__single_any_hit PKTRT__NAME(pktrt__single_any_hit)
#define pktrt__single_closest_hit PKTRT__NAME(pktrt__single_closest_hit)
#define pktrt__single_open_node PKTRT__NAME(pktrt__single_open_node)
#define pktrt__single_plane PKTRT__NAME(pktrt__single_plane)
#define pktrt__single_setup PKTRT__NAME(pktrt__single_setup)
#define pktrt__single_slabs PKTRT__NAME(pktrt__single_slabs)
#define pktrt__single_slabs_of PKTRT__NAME(pktrt__single_slabs_of)
#define pktrt__single_test_children PKTRT__NAME(pktrt__single_test_children)
#define pktrt__single_traverse PKTRT__NAME(pktrt__single_traverse)
#define pktrt__spawn_rays PKTRT__NAME(pktrt__spawn_rays)
#define pktrt__spawn_rays8 PKTRT__NAME(pktrt__spawn_rays8)
#define pktrt__stream_any_block PKTRT__NAME(pktrt__stream_any_block)
#define pktrt__stream_closest_block PKTRT__NAME(pktrt__stream_closest_block)
#define pktrt__stream_leaf PKTRT__NAME(pktrt__stream_leaf)
#define pktrt__stream_notes PKTRT__NAME(pktrt__stream_notes)
#define pktrt__stream_open_node PKTRT__NAME(pktrt__stream_open_node)
#define pktrt__stream_record PKTRT__NAME(pktrt__stream_record)
#define pktrt__stream_stack PKTRT__NAME(pktrt__stream_stack)
#define pktrt__stream_template PKTRT__NAME(pktrt__stream_template)
#define pktrt__stream_traverse PKTRT__NAME(pktrt__stream_traverse)
#define pktrt__surface_find PKTRT__NAME(pktrt__surface_find)
#define pktrt__surface_find8 PKTRT__NAME(pktrt__surface_find8)
#define pktrt__surface_gather_normals PKTRT__NAME(pktrt__surface_gather_normals)
#define pktrt__surface_offset8 PKTRT__NAME(pktrt__surface_offset8)
#define pktrt__surface_pack PKTRT__NAME(pktrt__surface_pack)
#define pktrt__surface_point8 PKTRT__NAME(pktrt__surface_point8)
#define pktrt__surface_read_materials PKTRT__NAME(pktrt__surface_read_materials)
#define pktrt__surface_start PKTRT__NAME(pktrt__surface_start)
#define pktrt__tri_any_block PKTRT__NAME(pktrt__tri_any_block)
#define pktrt__tri_any_hit PKTRT__NAME(pktrt__tri_any_hit)
#define pktrt__tri_any_turn PKTRT__NAME(pktrt__tri_any_turn)
#define pktrt__tri_block_template PKTRT__NAME(pktrt__tri_block_template)
#define pktrt__tri_candidates PKTRT__NAME(pktrt__tri_candidates)
#define pktrt__tri_common PKTRT__NAME(pktrt__tri_common)
#define pktrt__tri_corner PKTRT__NAME(pktrt__tri_corner)
#define pktrt__tri_corner_of_one PKTRT__NAME(pktrt__tri_corner_of_one)
#define pktrt__tri_decide_on_grid PKTRT__NAME(pktrt__tri_decide_on_grid)
#define pktrt__tri_decide_turn PKTRT__NAME(pktrt__tri_decide_turn)
#define pktrt__tri_directions_on_grid PKTRT__NAME(pktrt__tri_directions_on_grid)
#define pktrt__tri_depth_bounds PKTRT__NAME(pktrt__tri_depth_bounds)
#define pktrt__tri_edge_functions PKTRT__NAME(pktrt__tri_edge_functions)
#define pktrt__tri_edges PKTRT__NAME(pktrt__tri_edges)
#define pktrt__tri_estimate PKTRT__NAME(pktrt__tri_estimate)
#define pktrt__tri_filter_block PKTRT__NAME(pktrt__tri_filter_block)
#define pktrt__tri_inside PKTRT__NAME(pktrt__tri_inside)
#define pktrt__tri_limits PKTRT__NAME(pktrt__tri_limits)
#define pktrt__tri_limits_of PKTRT__NAME(pktrt__tri_limits_of)
#define pktrt__tri_rows PKTRT__NAME(pktrt__tri_rows)
#define pktrt__tri_outside PKTRT__NAME(pktrt__tri_outside)
#define pktrt__tri_ray_block PKTRT__NAME(pktrt__tri_ray_block)
#define pktrt__tri_ray_block_inline PKTRT__NAME(pktrt__tri_ray_block_inline)
#define pktrt__tri_occluders PKTRT__NAME(pktrt__tri_occluders)
#define pktrt__tri_record PKTRT__NAME(pktrt__tri_record)
#define pktrt__tri_settle PKTRT__NAME(pktrt__tri_settle)
#define pktrt__tri_settle_any PKTRT__NAME(pktrt__tri_settle_any)
#define pktrt__tri_settle_edges PKTRT__NAME(pktrt__tri_settle_edges)
#define pktrt__tri_shear PKTRT__NAME(pktrt__tri_shear)
#define pktrt__tri_shear_turn PKTRT__NAME(pktrt__tri_shear_turn)
#define pktrt__tri_shear_of PKTRT__NAME(pktrt__tri_shear_of)
#define pktrt__tri_single_block PKTRT__NAME(pktrt__tri_single_block)
#define pktrt__vec_along PKTRT__NAME(pktrt__vec_along)
#define pktrt__vec_on_grid PKTRT__NAME(pktrt__vec_on_grid)
#define pktrt__vec_ddot PKTRT__NAME(pktrt__vec_ddot)
#define pktrt__vec_dfrom3 PKTRT__NAME(pktrt__vec_dfrom3)
#define pktrt__vec_dload3 PKTRT__NAME(pktrt__vec_dload3)
#define pktrt__vec_dmax_abs3 PKTRT__NAME(pktrt__vec_dmax_abs3)
#define pktrt__vec_dot PKTRT__NAME(pktrt__vec_dot)
#define pktrt__vec_dset3 PKTRT__NAME(pktrt__vec_dset3)
#define pktrt__vec_disk PKTRT__NAME(pktrt__vec_disk)
#define pktrt__vec_load3 PKTRT__NAME(pktrt__vec_load3)
#define pktrt__vec_normalise PKTRT__NAME(pktrt__vec_normalise)
#define pktrt__vec_sincos PKTRT__NAME(pktrt__vec_sincos)
#define pktrt__vec_store3 PKTRT__NAME(pktrt__vec_store3)

/* >>setup ---------------------------------------------------------------------------------------------------------- */

/* STEP, SMALL and ROLL_OUT: on narrow vectors, short of registers, loops stay loops and larger steps calls: half the code.
   SHARED: where operations are calls, what consists of them is one too. */
#if PKTRT__WITH_V8_REGISTERS
#define STEP OP
#define SMALL PKTRT__NOINLINE
#define ROLL_OUT UNROLL
#else
#define STEP PKTRT__NOINLINE
#define SMALL PKTRT__COLD
#define ROLL_OUT
#endif
#if PKTRT__WITH_FEW_INSTANCES
#define SHARED PKTRT__NOINLINE
#else
#define SHARED OP
#endif

/* The lanes of a turn: a ray meets a block's triangles in turns. WHY: fewer values wait for registers, and half a block that
   the ray passes by costs little. */
#define PKTRT__TURN_LANES (8 / PKTRT__TURNS)
#define PKTRT__TURN_MASK ((1u << PKTRT__TURN_LANES) - 1)

#define COUNT(field, n)                                              \
  do {                                                               \
    if (PKTRT__STATS && is.stats) is.counts->field += (uint64_t)(n); \
  } while (0)

/* Tells whether the instance of a kernel that counts is run, which asks for weights of time at rest as well. */
#define COUNTED(is) ((is).stats || PKTRT__WITH_FEW_INSTANCES)

/* Derives the fields of a vector of rays from o, d, tmin, tmax; returns the bits of those that can hit anything. */
PKTRT__NOINLINE uint32_t pktrt__batch_setup(const pktrt_scene *scene, pktrt__batch *b, uint32_t i) {
  const vf zero = fset(0), dx = fload(b->d[0] + i), dy = fload(b->d[1] + i), dz = fload(b->d[2] + i);
  const vf ax = fabs_(dx), ay = fabs_(dy), az = fabs_(dz);
  const mf not_y = fmand(fle(ay, ax), fle(az, ax)), y = fle(az, ay); /* x if not_y, else y if y, else z */
  const vf dk = fsel(not_y, dx, fsel(y, dy, dz)), adk = fabs_(dk);
  fstore(b->slope[0] + i, fdiv(fsel(not_y, dy, fsel(y, dz, dx)), dk));
  fstore(b->slope[1] + i, fdiv(fsel(not_y, dz, fsel(y, dx, dy)), dk));
  fstore(b->dk + i, dk);
  const uint32_t x_bits = fbits(not_y), y_bits = fbits(y), sx = fsignbits(dx), sy = fsignbits(dy), sz = fsignbits(dz);
  for (uint32_t j = 0; j < FW; j += 8) {
    vstore_bytes(b->axis + i + j, (~x_bits & y_bits) >> j, ~(x_bits | y_bits) >> j, 0);
    vstore_bytes(b->octant + i + j, sx >> j, sy >> j, sz >> j);
  }

  /* M and |o|, then D */
  vf m = zero, o_max = zero;
  UNROLL for (int a = 0; a < 3; a++) {
    const vf o = fload(b->o[a] + i);
    m = fmax_(m, fmax_(fsub(fset(scene->hi[a]), o), fsub(o, fset(scene->lo[a]))));
    o_max = fmax_(o_max, fabs_(o));
  }
  const vf pad =
      fadd(fadd(fmul(m, fset(PKTRT__PAD_M * scene->stretch)), fmul(o_max, fset(PKTRT__PAD_O * scene->stretch))),
           fset(PKTRT__PAD_MIN));
  fstore(b->pad + i, pad);

  /* 1/G; directions below 2^-60 are scaled first, where |d_k| 2^-26 would lose bits */
  const vf up = fsel(flt(adk, fset(8.673617379884035e-19f)), fset(18446744073709551616.0f), fset(1));
  const vf length = fmul(adk, up), floor_ = fmul(length, fset(1.490116119384765625e-8f));
  UNROLL for (int a = 0; a < 3; a++) {
    const vf d = fmul(fload(b->d[a] + i), up), o = fload(b->o[a] + i);
    const vf rd = fdiv(length, fcopysign(fmax_(fabs_(d), floor_), d));
    const vf c = fmul(o, rd), wide = fmul(pad, fabs_(rd));
    fstore(b->rd[a] + i, rd);
    fstore(b->as.slab.cn[a] + i, fadd(c, wide));
    fstore(b->as.slab.cf[a] + i, fsub(c, wide));
  }

  const vf tmin = fload(b->tmin + i), tmax = fload(b->tmax + i), relative = fset(PKTRT__PAD_DEPTH);
  const vf tiny = fmul(fmax_(adk, fset(1)), fset(PKTRT__PAD_TINY));
  const vf n = fmul(tmin, adk), f = fmul(tmax, adk), last = fmul(fmin_(tmax, fset(FLT_MAX)), adk);
  const vf n_slack = fadd(fmul(fabs_(n), relative), tiny), f_slack = fadd(fmul(fabs_(f), relative), tiny);
  fstore(b->tiny + i, tiny);
  fstore(b->wn + i, fsub(n, n_slack));
  fstore(b->wf + i, fadd(f, f_slack));
  fstore(b->sn + i, fmax_(fadd(n, n_slack), n)); /* an infinite end stays infinite */
  fstore(b->sf + i, fmin_(fsub(last, fadd(fmul(fabs_(last), relative), tiny)), last));
  fstore(b->t + i, tmax);
  memset(b->id + i, 0, FW * sizeof *b->id);
  memset(b->slot + i, 0xFF, FW * sizeof *b->slot); /* PKTRT_NONE */
  memset(b->place + i, 0, FW * sizeof *b->place);

  const vf largest = fset(FLT_MAX); /* adk may be no NaN where there is one: all three are tested */
  mf ok = fmand(flt(zero, adk), flt(tmin, tmax));
  ok = fmand(ok, fmand(fle(ax, largest), fmand(fle(ay, largest), fle(az, largest))));
  UNROLL for (int a = 0; a < 3; a++) ok = fmand(ok, fle(fabs_(fload(b->o[a] + i)), fset(PKTRT_MAX_COORD)));
  /* Nothing can lie beyond the range of floats, where wn or wf would be NaN and spoil a packet's extremes. */
  ok = fmand(ok, fmand(flt(n, fset(INFINITY)), flt(fset(-INFINITY), f)));
  return fbits(ok);
}

/* Derives the fields of a single ray, with axes side by side; returns whether it can hit anything. */
#if PKTRT__WITH_V8_REGISTERS
OP
#else
PKTRT__NOINLINE
#endif
    bool
    pktrt__single_setup(const pktrt_scene *scene, const pktrt_ray *ray, pktrt__single *q) {
  static const float most[8] = {PKTRT_MAX_COORD, PKTRT_MAX_COORD, PKTRT_MAX_COORD, INFINITY,
                                FLT_MAX,         FLT_MAX,         FLT_MAX,         INFINITY};
  const float *const o = ray->origin, *const d = ray->direction;
  const v8 od = vload((const float *)(const void *)ray), size = vabs(od);
  const float ax = fabsf(d[0]), ay = fabsf(d[1]), az = fabsf(d[2]), tmin = ray->tmin, tmax = ray->tmax;
  const float adk = pktrt__maxf(pktrt__maxf(ax, ay), az), n = tmin * adk, f = tmax * adk;
  const uint32_t not_x = ax < adk, k = not_x << (not_x & (ay < adk));
  if (~mbits(vle(size, vload(most))) & 0x77) return false;
  if (!(0 < adk && tmin < tmax && n < INFINITY && -INFINITY < f)) return false; /* as in pktrt__batch_setup */
  q->ray = ray, q->octant = vsignbits(od) >> 4 & 7, q->axis = pktrt__axes[k], q->dk = d[k];
  q->slope[0] = d[q->axis[1]] / q->dk, q->slope[1] = d[q->axis[2]] / q->dk;

  const float *const lo = scene->lo, *const hi = scene->hi;
  const float mx = pktrt__maxf(hi[0] - o[0], o[0] - lo[0]), my = pktrt__maxf(hi[1] - o[1], o[1] - lo[1]);
  const float m = pktrt__maxf(pktrt__maxf(hi[2] - o[2], o[2] - lo[2]), pktrt__maxf(mx, my));
  const float o_max = pktrt__maxf(fabsf(o[0]), pktrt__maxf(fabsf(o[1]), fabsf(o[2])));
  q->pad = (m * PKTRT__PAD_M + o_max * PKTRT__PAD_O) * scene->stretch + PKTRT__PAD_MIN;
  const float up = 18446744073709551616.0f;
  float length = adk;
  v8 along = vswap_halves(od);
  if (PKTRT__UNLIKELY(adk < 8.673617379884035e-19f)) length *= up, along = vmul(along, vset(up));
  const v8 least = vset(length * 1.490116119384765625e-8f);
  const v8 rd = vdiv(vset(length), vcopysign(vmax(vabs(along), least), along));
  const v8 c = vmul(od, rd), wide = vmul(vset(q->pad), vabs(rd));
  vstore(q->rd, rd);
  vstore(q->cn, vadd(c, wide));
  vstore(q->cf, vsub(c, wide));

  const float tiny = pktrt__maxf(adk, 1) * PKTRT__PAD_TINY, last = pktrt__minf(f, FLT_MAX * adk);
  const float n_slack = fabsf(n) * PKTRT__PAD_DEPTH + tiny, f_slack = fabsf(f) * PKTRT__PAD_DEPTH + tiny;
  q->tiny = tiny, q->wn = n - n_slack, q->wf = f + f_slack, q->sn = pktrt__maxf(n + n_slack, n);
  q->sf = pktrt__minf(last - (fabsf(last) * PKTRT__PAD_DEPTH + tiny), last);
  q->id = q->place = 0, q->slot = q->after = PKTRT_NONE;
  return true;
}

/* Computes the time weights of rays [first, first + n) for a BVH of `keys` keys. */
OP void pktrt__batch_time_weights(pktrt__batch *b, uint32_t first, uint32_t n, uint32_t keys) {
  float ta;
  for (uint32_t i = first; i < first + n; i++)
    b->segment[i] = (uint16_t)pktrt__time_segment(b->time[i], keys, &ta, &b->tb[i]);
}

/* Computes the time weights of the 64 rays of a packet; two keys have but one segment. */
OP void pktrt__batch_packet_time_weights(pktrt__batch *b, uint32_t base, uint32_t keys) {
  if (keys > 2) {
    pktrt__batch_time_weights(b, base, 64, keys);
    return;
  }
  for (uint32_t r = base; r < base + 64; r += 8) vstore(b->tb + r, vmin(vmax(vload(b->time + r), vset(0)), vset(1)));
}

/* >>triangles ------------------------------------------------------------------------------------------------------ */

/* Returns the lanes of a block that hold a triangle. */
OP uint32_t pktrt__lanes_occupied(const uint32_t *id) { return 0xFFu & ~veq_u32(id, PKTRT_NONE); }

/* Returns the rays, of eight, that hit nothing yet. */
OP uint32_t pktrt__lanes_unhit(const uint32_t *slot) { return veq_u32(slot, PKTRT_NONE); }

/* The result of the filter in single precision for eight lanes, each a ray and a triangle. */
typedef struct pktrt__tri_estimate {
  v8 lo, hi; /* bounds of the depth of a hit */
  uint32_t maybe, inside,
      after; /* lanes that may be hits worth recording; that are crossed; are after tmin, if crossed */
} pktrt__tri_estimate;

/* The values of rays that the filter needs, by lanes. */
typedef struct pktrt__tri_limits {
  v8 sign, tiny, wn, wf, sn, sf;
} pktrt__tri_limits;

/* The edge functions of eight lanes, the least and the largest of the three, and how wrong they may be, see >>exactness. */
typedef struct pktrt__tri_edges {
  v8 u, v, w, least, most, error;
} pktrt__tri_edges;

/* Bounds the error of edge functions by the largest |x|, |y|, |z|; overflows where a product does. op is v or f. */
#define PKTRT__EDGE_ERROR(op, xs, ys, zs)                                                                   \
  op##fma(op##mul(zs, op##set(PKTRT__PAD_SHEAR)), op##fma(zs, op##set(PKTRT__PAD_SHEAR2), op##add(xs, ys)), \
          op##fma(op##mul(xs, ys), op##set(PKTRT__PAD_CROSS), op##set(PKTRT__PAD_LEAST)))

SHARED pktrt__tri_edges pktrt__tri_edge_functions(const v8 x[3], const v8 y[3], const v8 z[3]) {
  pktrt__tri_edges e;
  e.u = vfms(x[2], y[1], vmul(y[2], x[1]));
  e.v = vfms(x[0], y[2], vmul(y[0], x[2]));
  e.w = vfms(x[1], y[0], vmul(y[1], x[0]));
  e.least = vmin(e.u, vmin(e.v, e.w)), e.most = vmax(e.u, vmax(e.v, e.w));
  e.error = PKTRT__EDGE_ERROR(v, vmax_abs3(x[0], x[1], x[2]), vmax_abs3(y[0], y[1], y[2]), vmax_abs3(z[0], z[1], z[2]));
  return e;
}
/* Returns the lanes whose edge functions have both signs for certain, and those where all have one sign for certain. */
OP uint32_t pktrt__tri_outside(const pktrt__tri_edges *e) {
  return mbits(vlt(e->error, vmin(e->most, vsub(vset(0), e->least))));
}
OP uint32_t pktrt__tri_inside(const pktrt__tri_edges *e) {
  return mbits(vlt(e->error, vmax(e->least, vsub(vset(0), e->most))));
}

/* Bounds the error of an estimated depth, see >>exactness: B R / |D| + 16 eps Z + tiny; for any hit all times |D|. */
#define PKTRT__DEPTH_REACH(op, z, tiny) op##fma(z, op##set(PKTRT__PAD_ESTIMATE), tiny)

/* Bounds the depths of hits by the estimate of >>exactness, for lanes whose edge functions do not rule a hit out. */
SHARED pktrt__tri_estimate pktrt__tri_depth_bounds(const pktrt__tri_edges *q, const v8 z[3],
                                                   const pktrt__tri_limits *l) {
  const v8 det = vadd(vadd(q->u, q->v), q->w), size = vabs(det), r = vdiv(l->sign, det);
  const v8 z_lo = vmin(z[0], vmin(z[1], z[2])), z_hi = vmax(z[0], vmax(z[1], z[2]));
  const v8 depth = vfma(vmul(q->u, r), z[0], vfma(vmul(q->v, r), z[1], vmul(vmul(q->w, r), z[2])));
  const m8 known = mand(vlt(vmul(vset(PKTRT__LEAST_DET), q->error), size), vle(size, vset(FLT_MAX)));
  const v8 error =
      vfma(vmul(q->error, vabs(r)), vsub(z_hi, z_lo), PKTRT__DEPTH_REACH(v, vmax_abs(z_lo, z_hi), l->tiny));
  const v8 bound = vsel(known, error, vset(INFINITY));
  pktrt__tri_estimate e;
  e.lo = vsub(depth, bound), e.hi = vadd(depth, bound);
  e.maybe = 0xFFu & ~mbits(mor(vlt(l->wf, e.lo), vlt(e.hi, l->wn)));
  e.inside = pktrt__tri_inside(q), e.after = mbits(vlt(l->sn, e.lo));
  return e;
}

/* Loads one coordinate of a corner of the triangles of a turn, at the ray's time. */
OP v8 pktrt__tri_corner(const float *k0, const float *k1, v8 ta, v8 tb, const bool moving) {
  return moving ? vadd(vmul(ta, vload_turn(k0, 0)), vmul(tb, vload_turn(k1, 0))) : vload_turn(k0, 0);
}

/* A ray as triangle tests need it, the same in every lane. */
typedef struct pktrt__tri_shear {
  v8 o[3], slope[2], ta, tb; /* by k, u, v */
  uint32_t at[3];            /* where a corner's coordinates stand, in floats */
  const pktrt__batch *b;     /* whose ray r it is, if not a single one */
  const pktrt__single *single;
  uint32_t r;
} pktrt__tri_shear;

/* Where the coordinates along a ray's axes k, u and v stand in a batch. */
static const uint32_t pktrt__tri_rows[3][3] = {
    {0, PKTRT__ROW, 2 * PKTRT__ROW}, {PKTRT__ROW, 2 * PKTRT__ROW, 0}, {2 * PKTRT__ROW, 0, PKTRT__ROW}};

/* Of a ray of a batch or, if `single` is not NULL, of a single ray. */
SHARED pktrt__tri_shear pktrt__tri_shear_of(const pktrt__batch *b, uint32_t r, const pktrt__single *single,
                                            const bool moving) {
  pktrt__tri_shear q;
  const uint32_t *axis = single ? single->axis : pktrt__axes[b->axis[r]];
  const uint32_t *row = single ? axis : pktrt__tri_rows[b->axis[r]];
  const float *o = single ? single->ray->origin : &b->o[0][r];
  UNROLL for (int i = 0; i < 3; i++) q.o[i] = vset(o[row[i]]), q.at[i] = 8 * axis[i];
  UNROLL for (int i = 0; i < 2; i++) q.slope[i] = vset(single ? single->slope[i] : b->slope[i][r]);
  q.ta = q.tb = q.o[0], q.b = b, q.single = single, q.r = r;
  if (moving) q.tb = vset(single ? single->tb : b->tb[r]), q.ta = vsub(vset(1), q.tb);
  return q;
}
/* WHY apart: most blocks are dropped before depths are looked at. */
SHARED pktrt__tri_limits pktrt__tri_limits_of(const pktrt__tri_shear *q) {
  const pktrt__batch *b = q->b;
  const pktrt__single *single = q->single;
  const uint32_t r = q->r;
  pktrt__tri_limits l;
  l.sign = vcopysign(vset(1), vset(single ? single->dk : b->dk[r])), l.tiny = vset(single ? single->tiny : b->tiny[r]);
  l.wn = vset(single ? single->wn : b->wn[r]), l.wf = vset(single ? single->wf : b->wf[r]);
  l.sn = vset(single ? single->sn : b->sn[r]), l.sf = vset(single ? single->sf : b->sf[r]);
  return l;
}

/* Shears the corners of a turn's triangles to the ray's frame; x and y are both negated, which cancels in products. */
SHARED void pktrt__tri_shear_turn(const pktrt__tri_shear *q, const pktrt__bvh_segment *seg, const pktrt__block *block,
                                  uint32_t first, v8 x[3], v8 y[3], v8 z[3], const bool moving) {
  const float *k0 = pktrt__segment_vertices(seg, block, 0, moving) + first,
              *k1 = pktrt__segment_vertices(seg, block, 1, moving) + first;
  const uint32_t k = q->at[0], u = q->at[1], v = q->at[2];
  UNROLL for (int c = 0; c < 3; c++, k0 += 24, k1 += 24) {
    z[c] = vsub(pktrt__tri_corner(k0 + k, k1 + k, q->ta, q->tb, moving), q->o[0]);
    x[c] = vfms(q->slope[0], z[c], vsub(pktrt__tri_corner(k0 + u, k1 + u, q->ta, q->tb, moving), q->o[1]));
    y[c] = vfms(q->slope[1], z[c], vsub(pktrt__tri_corner(k0 + v, k1 + v, q->ta, q->tb, moving), q->o[2]));
  }
}

/* Lanes of a block that the filter did not drop. */
typedef struct pktrt__tri_candidates {
  uint32_t index; /* of the block */
  const uint32_t *id;
  float *lo, *hi;                /* bounds of depths */
  uint32_t maybe, inside, after; /* as in pktrt__tri_estimate; for any hit `after` is within the ray's interval */
  bool settled;                  /* all that is open, as far as that goes */
} pktrt__tri_candidates;

/* Filters the triangles of a block in single precision, bounds of their depths in lo and hi, 8 floats each; `early`:
   without the estimate where nothing is hit. */
OP pktrt__tri_candidates pktrt__tri_filter_block(const pktrt__tri_shear *q, const pktrt__bvh_segment *seg,
                                                 const pktrt__block *block, uint32_t index, const bool early, float *lo,
                                                 float *hi, const bool moving) {
  const uint32_t occupied = pktrt__lanes_occupied(block->id);
  pktrt__tri_candidates c = {index, block->id, lo, hi, 0, 0, 0, false};
  for (uint32_t first = 0; first < 8; first += PKTRT__TURN_LANES) {
    v8 x[3], y[3], z[3];
    pktrt__tri_shear_turn(q, seg, block, first, x, y, z, moving);
    const pktrt__tri_edges edges = pktrt__tri_edge_functions(x, y, z);
    const uint32_t open = occupied >> first & ~pktrt__tri_outside(&edges) & PKTRT__TURN_MASK;
    if (early && !open) continue;
    const pktrt__tri_limits l = pktrt__tri_limits_of(q);
    const pktrt__tri_estimate e = pktrt__tri_depth_bounds(&edges, z, &l);
    vstore_turn(lo + first, e.lo), vstore_turn(hi + first, e.hi);
    c.maybe |= (e.maybe & open) << first;
    c.inside |= (e.inside & PKTRT__TURN_MASK) << first, c.after |= (e.after & PKTRT__TURN_MASK) << first;
  }
  return c;
}

/* What pktrt__exact_edge_functions finds, for eight lanes: the same bits. */
typedef struct pktrt__exact_edges8 {
  d8 u, v, w, det, depth;
} pktrt__exact_edges8;
OP d8 pktrt__vec_dmax_abs3(d8 a, d8 b, d8 c) { return dmax(dabs(a), dmax(dabs(b), dabs(c))); }
OP pktrt__exact_edges8 pktrt__exact_edge_functions8(const d8 x[3], const d8 y[3], const d8 z[3]) {
  pktrt__exact_edges8 e;
  e.u = dsub(dmul(x[2], y[1]), dmul(y[2], x[1])), e.v = dsub(dmul(x[0], y[2]), dmul(y[0], x[2]));
  e.w = dsub(dmul(x[1], y[0]), dmul(y[1], x[0])), e.det = dadd(dadd(e.u, e.v), e.w);
  e.depth = dadd(dadd(dmul(e.u, z[0]), dmul(e.v, z[1])), dmul(e.w, z[2]));
  return e;
}
/* Finds their error, and the lanes where t, u and v are calm. */
OP uint32_t pktrt__exact_calm8(const pktrt__exact_edges8 *e, const d8 x[3], const d8 y[3], const d8 z[3], d8 dk,
                               d8 *error) {
  const d8 zero = dset(0), xs = pktrt__vec_dmax_abs3(x[0], x[1], x[2]), ys = pktrt__vec_dmax_abs3(y[0], y[1], y[2]);
  const d8 hi = dmax(z[0], dmax(z[1], z[2]));
  const d8 lo = dsub(zero, dmax(dsub(zero, z[0]), dmax(dsub(zero, z[1]), dsub(zero, z[2]))));
  const d8 zs = dmul(dmax(hi, dsub(zero, lo)), dabs(dk));
  const d8 near_ = dmul(dmul(dset(8 * PKTRT__EPS2), zs), dadd(dadd(xs, ys), dmul(dset(32 * PKTRT__EPS2), zs)));
  *error = dadd(dmul(dmul(dset(16 * PKTRT__EPS2), xs), ys), near_);
  const d8 wrong = dmul(*error, dsub(hi, lo)), depth = dabs(e->depth);      /* of depth, 5 times that at most */
  const m8 calm_uv = dlt(*error, dmul(dabs(e->det), dset(PKTRT__CALM_UV))); /* and so as t needs it */
  return mbits(mand(calm_uv, dlt(wrong, dmul(depth, dset(PKTRT__CALM_T)))));
}

/* The corners of eight triangles, or of one as eight rays see it, in the rays' frames, as in >>exactness. */
STEP void pktrt__exact_shear8(const v8 p[3], const v8 o[3], const v8 d[3], d8 *x, d8 *y, d8 *z) {
  const d8 dk = dfrom(d[0]);
  *z = dsub(dfrom(p[0]), dfrom(o[0]));
  *x = dsub(dmul(dsub(dfrom(p[1]), dfrom(o[1])), dk), dmul(dfrom(d[1]), *z));
  *y = dsub(dmul(dsub(dfrom(p[2]), dfrom(o[2])), dk), dmul(dfrom(d[2]), *z));
}

/* Tells which of eight values are multiples of the last bit of a number. */
OP m8 pktrt__vec_on_grid(v8 x, v8 of) { return veq(x, vsub(vadd(x, of), of)); }
/* Tells which of eight directions lie on the grid of their own, see >>exactness: few but those of lattices. */
OP uint32_t pktrt__tri_directions_on_grid(const v8 d[3]) {
  const v8 turn = vmul(vabs(d[0]), vset(2097152));
  const m8 sides = mand(pktrt__vec_on_grid(d[1], turn), pktrt__vec_on_grid(d[2], turn));
  return mbits(mand(pktrt__vec_on_grid(d[0], turn), sides));
}

/* Decides edges of lanes in `open`, whose directions lie on grids, where all else does: returns those not crossed, the others
   are *crossed. Doubles have products of x and y exactly, floats their signs, where M |d_k| is moderate. */
OP uint32_t pktrt__tri_decide_turn(v8 p[3][3], const v8 o[3], const v8 d[3], uint32_t open, uint32_t *crossed) {
  const v8 zero = vset(0), sign = vcopysign(vset(1), d[0]);
  v8 most = vmax_abs3(o[0], o[1], o[2]), x[3], y[3];
  UNROLL for (int c = 0; c < 3; c++) most = vmax(most, vmax_abs3(p[c][0], p[c][1], p[c][2]));
  const v8 coarse = vmul(most, vset(128)), size = vmul(most, vabs(d[0]));
  m8 even = mand(vlt(vset(PKTRT__GRID_LEAST), size), vlt(size, vset(PKTRT__GRID_MOST)));
  UNROLL for (int a = 0; a < 3; a++) {
    even = mand(even, pktrt__vec_on_grid(o[a], coarse));
    UNROLL for (int c = 0; c < 3; c++) even = mand(even, pktrt__vec_on_grid(p[c][a], coarse));
  }
  open &= mturn(even);
  if (!open) return 0;
  UNROLL for (int c = 0; c < 3; c++) {
    const v8 z = vsub(p[c][0], o[0]);
    x[c] = vsub(vmul(vsub(p[c][1], o[1]), d[0]), vmul(d[1], z)),
    y[c] = vsub(vmul(vsub(p[c][2], o[2]), d[0]), vmul(d[2], z));
  }
  v8 least = zero, largest = zero;
  UNROLL for (int i = 0, a = 2, b = 1; i < 3; b = a, a = i++) {
    const v8 one = vmul(x[a], y[b]), other = vmul(y[a], x[b]);
    v8 value = vsub(one, other);
    const uint32_t same = open & mturn(veq(one, other));
    if (same & ~mturn(veq(one, zero))) /* in doubles exactly */
      value = dto(dsub(dmul(dfrom(x[a]), dfrom(y[b])), dmul(dfrom(y[a]), dfrom(x[b]))));
    if (same) { /* what >>exactness compares, for x and y are exact; zero again: the other edges have both signs, or none */
      const v8 tie = vsel(veq(y[a], y[b]), vsub(x[b], x[a]), vsub(y[a], y[b]));
      value = vsel(veq(value, zero), vmul(sign, tie), value);
    }
    least = vmin(least, value), largest = vmax(largest, value);
  }
  *crossed = open & (mturn(vlt(least, zero)) ^ mturn(vlt(zero, largest)));
  return open & ~*crossed;
}
/* Does so for corners p as a block has them, in turns: takes the former from *maybe, adds the latter to *crossed. WHY turns: few
   lanes are open at a time, and what is asked of half a vector alone is computed for that half. */
PKTRT__NOINLINE void pktrt__tri_decide_on_grid(const float *p, const uint32_t *axis, const v8 o[3], const v8 d[3],
                                               uint32_t open, uint32_t *maybe, uint32_t *crossed) {
  for (uint32_t turn = 0; turn < PKTRT__TURNS; turn++) {
    const uint32_t first = PKTRT__TURN_LANES * turn, lanes = open >> first & PKTRT__TURN_MASK;
    v8 corners[3][3], from[3], along[3];
    uint32_t yes = 0;
    if (!lanes) continue;
    UNROLL for (int i = 0; i < 3; i++) {
      from[i] = vturn(o[i], turn), along[i] = vturn(d[i], turn);
      UNROLL for (int c = 0; c < 3; c++) corners[c][i] = vload_turn(p + 24 * c + 8 * axis[i], turn);
    }
    *maybe &= ~(pktrt__tri_decide_turn(corners, from, along, lanes, &yes) << first), *crossed |= yes << first;
  }
}

/* Decides candidates at rest whose edges the filter left open, as far as it can: drops them, or makes them sure. */
PKTRT__NOINLINE void pktrt__tri_settle_edges(const pktrt__bvh_segment *seg, const pktrt__batch *b, uint32_t r,
                                             const pktrt__single *single, pktrt__tri_candidates *c) {
  const pktrt__block *block = pktrt__segment_block(seg, c->index, true);
  const float *k = pktrt__segment_vertices(seg, block, 0, true), *from = single ? single->ray->origin : &b->o[0][r];
  const float *along = single ? single->ray->direction : &b->d[0][r];
  const uint32_t *axis = single ? single->axis : pktrt__axes[b->axis[r]], row = single ? 1 : PKTRT__ROW;
  v8 o[3], d[3];
  UNROLL for (int i = 0; i < 3; i++) o[i] = vset(from[row * axis[i]]), d[i] = vset(along[row * axis[i]]);
  if (pktrt__segment_vertices(seg, block, 1, true) == k && pktrt__tri_directions_on_grid(d))
    pktrt__tri_decide_on_grid(k, axis, o, d, c->maybe & ~c->inside, &c->maybe, &c->inside);
}

/* Decides whether a candidate is the closest hit so far, and makes it that. WHY edges first, and not depths: where these
   are open the ray mostly leaves a surface, of one triangle, see pktrt__exact_is_apart. */
PKTRT__NOINLINE bool pktrt__tri_settle(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r,
                                       pktrt__single *single, pktrt__tri_candidates *c, uint32_t lane) {
  const uint32_t slot = c->index * 8 + lane, id = c->id[lane];
  if (id == (single ? single->id : b->id[r]) && (single ? single->slot : b->slot[r]) != PKTRT_NONE)
    return false; /* a split triangle, again */
  if (PKTRT__WITH_VECTORS && (c->maybe & ~c->inside) && !c->settled) {
    pktrt__tri_settle_edges(seg, b, r, single, c);
    c->settled = true;
    if (!(c->maybe >> lane & 1)) return false;
    if ((c->inside & c->after) >> lane & 1 && c->hi[lane] < (single ? single->sf : b->sf[r])) {
      if (single) pktrt__single_set_hit(seg, single, c->lo[lane], c->hi[lane], id, slot);
      else pktrt__batch_set_hit(seg, b, r, c->lo[lane], c->hi[lane], id, slot);
      return true;
    }
  }
  if (c->after >> lane & 1) /* not apart */
    return single ? pktrt__exact_test_rest(seg, single, id, slot) : pktrt__exact_test_rest_of(seg, b, r, id, slot);
  return single ? pktrt__exact_test_single(seg, single, id, slot) : pktrt__exact_test(seg, b, r, id, slot);
}

/* Records each candidate that is hit nearer than the closest hit before it, for a ray of a batch or, if `single` is not
   NULL, for a single ray; returns their lanes. For occlusion the first hit is the last. */
OP uint32_t pktrt__tri_record(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, pktrt__single *single,
                              pktrt__tri_candidates *c, const pktrt__variant is) {
  uint32_t nearer = 0;
  COUNT(canonical_tests, pktrt__popcount(c->maybe));
  for (uint32_t lane; c->maybe; c->maybe &= ~(1u << lane)) {
    lane = pktrt__lowest_bit(c->maybe);
    const uint32_t slot = c->index * 8 + lane, id = c->id[lane];
    if (c->lo[lane] > (single ? single->wf : b->wf[r])) continue;
    if ((c->inside & c->after) >> lane & 1 && c->hi[lane] < (single ? single->sf : b->sf[r])) {
      if (!is.occlusion && single) pktrt__single_set_hit(seg, single, c->lo[lane], c->hi[lane], id, slot);
      else if (!is.occlusion) pktrt__batch_set_hit(seg, b, r, c->lo[lane], c->hi[lane], id, slot);
      nearer |= 1u << lane;
    } else {
      COUNT(settlings, 1);
      if (pktrt__tri_settle(seg, b, r, single, c, lane)) nearer |= 1u << lane;
    }
    if (is.occlusion && nearer) return nearer;
  }
  return nearer;
}

/* Tests the lanes of a block that the filter left open, until one is hit; returns whether one is. `inside`: those crossed,
   `within`: those within the ray's interval, if they are. */
PKTRT__NOINLINE bool pktrt__tri_settle_any(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r,
                                           pktrt__single *single, uint32_t index, uint32_t open, uint32_t inside,
                                           uint32_t within) {
  const pktrt__block *block = pktrt__segment_block(seg, index, true);
  const uint32_t *id = block->id;
  for (; open && !(open & ~inside); open &= open - 1) { /* mostly of the surface where the ray ends */
    const uint32_t lane = pktrt__lowest_bit(open), slot = index * 8 + lane;
    if (single ? pktrt__exact_test_single(seg, single, id[lane], slot) : pktrt__exact_test(seg, b, r, id[lane], slot))
      return true;
  }
  if (!open) return false;
  float lo[8], hi[8];
  pktrt__tri_candidates c = {index, id, lo, hi, open, inside, within, false};
  vstore(lo, vset(-INFINITY)), vstore(hi, vset(-INFINITY)); /* as near as can be: any will do */
  for (uint32_t lane; c.maybe; c.maybe &= ~(1u << lane)) {
    lane = pktrt__lowest_bit(c.maybe);
    if (pktrt__tri_settle(seg, b, r, single, &c, lane)) return true;
  }
  return false;
}

/* Triangles of a turn that may be hit. */
typedef struct pktrt__tri_occluders {
  uint32_t open, inside, within; /* not dropped; crossed; within the interval, if crossed, both for certain */
} pktrt__tri_occluders;
/* Finds which of them a ray hits within its interval. Depths are not divided by the determinant; limits are multiplied by
   it. WHY fused: the product of a tiny limit by itself would be denormal, which is slow. */
OP pktrt__tri_occluders pktrt__tri_any_turn(const pktrt__tri_limits *l, const v8 z[3], const pktrt__tri_edges *e,
                                            uint32_t may) {
  const v8 zero = vset(0), det = vadd(vadd(e->u, e->v), e->w), size = vabs(det);
  const v8 sum = vmul(vfma(e->u, z[0], vfma(e->v, z[1], vmul(e->w, z[2]))), l->sign);
  const v8 depth = vmul(sum, vcopysign(vset(1), det));
  const v8 z_lo = vmin(z[0], vmin(z[1], z[2])), z_hi = vmax(z[0], vmax(z[1], z[2]));
  const v8 reach = PKTRT__DEPTH_REACH(v, vmax_abs(z_lo, z_hi), l->tiny);
  const v8 error = vfma(e->error, vsub(z_hi, z_lo), vfma(reach, size, vset(FLT_MIN)));
  const v8 lo = vsub(depth, error), hi = vadd(depth, error);
  const m8 sized = vlt(vmul(vset(PKTRT__LEAST_DET), e->error), size), bounded = vlt(error, vset(PKTRT__MOST_ERROR));
  const uint32_t known = may & mbits(mand(sized, bounded));
  const uint32_t beyond = mbits(vlt(vfms(l->wf, size, lo), zero)) | mbits(vlt(zero, vfms(l->wn, size, hi)));
  pktrt__tri_occluders o;
  o.open = may & ~(known & beyond), o.inside = pktrt__tri_inside(e);
  o.within = known & mbits(vlt(vfms(l->sn, size, lo), zero)) & mbits(vlt(zero, vfms(l->sf, size, hi)));
  return o;
}

/* Finds what a ray may hit within its interval in a block; `early`: without depths where it crosses nothing, and no
   further once it hits something for certain. */
OP pktrt__tri_occluders pktrt__tri_any_block(const pktrt__tri_shear *q, const pktrt__bvh_segment *seg,
                                             const pktrt__block *block, const bool early, const bool moving) {
  const uint32_t occupied = pktrt__lanes_occupied(block->id);
  pktrt__tri_occluders all = {0, 0, 0};
  for (uint32_t first = 0; first < 8 && !(early && (all.open & all.inside & all.within)); first += PKTRT__TURN_LANES) {
    v8 x[3], y[3], z[3];
    pktrt__tri_shear_turn(q, seg, block, first, x, y, z, moving);
    const pktrt__tri_edges e = pktrt__tri_edge_functions(x, y, z);
    const uint32_t may = occupied >> first & ~pktrt__tri_outside(&e) & PKTRT__TURN_MASK;
    if (early && !may) continue;
    const pktrt__tri_limits l = pktrt__tri_limits_of(q);
    const pktrt__tri_occluders o = pktrt__tri_any_turn(&l, z, &e, may);
    all.open |= o.open << first, all.inside |= (o.inside & PKTRT__TURN_MASK) << first, all.within |= o.within << first;
  }
  return all;
}

/* Tells whether a ray of a batch or a single ray hits anything in a block. */
OP bool pktrt__tri_any_hit(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, pktrt__single *single,
                           uint32_t index, const bool moving) {
  const pktrt__tri_shear q = pktrt__tri_shear_of(b, r, single, moving);
  const pktrt__tri_occluders o = pktrt__tri_any_block(&q, seg, pktrt__segment_block(seg, index, moving), true, moving);
  if (o.open & o.inside & o.within) return true;
  return PKTRT__UNLIKELY(o.open) && pktrt__tri_settle_any(seg, b, r, single, index, o.open, o.inside, o.within);
}

/* >>boxes ---------------------------------------------------------------------------------------------------------- */

/* The six planes of a node's children, of two keys if moving; near and far by the octant of the rays. */
typedef struct pktrt__box_slabs {
  v8 near0[3], far0[3], near1[3], far1[3];
} pktrt__box_slabs;

OP pktrt__box_slabs pktrt__box_load_slabs(const pktrt__bvh_segment *seg, const pktrt__node *node, uint32_t octant,
                                          const bool moving) {
  pktrt__box_slabs s;
  const float *p0 = pktrt__segment_planes(seg, node, 0, moving), *p1 = pktrt__segment_planes(seg, node, 1, moving);
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    const uint32_t n = 16 * a + 8 * (octant >> a & 1), f = 16 * a + 8 * (~octant >> a & 1);
    s.near0[a] = vload(p0 + n), s.far0[a] = vload(p0 + f);
    if (moving) s.near1[a] = vsub(vload(p1 + n), s.near0[a]), s.far1[a] = vsub(vload(p1 + f), s.far0[a]);
  }
  return s;
}

/* Tests one ray against eight children; returns those it may hit, and finds its entry depths. */
SHARED m8 pktrt__box_test_children(const pktrt__box_slabs *s, const pktrt__batch *b, uint32_t r, const bool moving,
                                   v8 *entry) {
  v8 n = vset(b->wn[r]), f = vset(b->wf[r]);
  UNROLL for (int a = 0; a < 3; a++) {
    const v8 rd = vset(b->rd[a][r]);
    v8 near_ = s->near0[a], far_ = s->far0[a];
    if (moving) {
      const v8 t = vset(b->tb[r]);
      near_ = vfma(t, s->near1[a], near_);
      far_ = vfma(t, s->far1[a], far_);
    }
    n = vmax(vfms(near_, rd, vset(b->as.slab.cn[a][r])), n);
    f = vmin(vfms(far_, rd, vset(b->as.slab.cf[a][r])), f);
  }
  *entry = n;
  return vle(n, f);
}

/* Tests rays r to r+7 against one box, with lo and hi by ray, as time may move it; returns those that may hit it. An
   empty box, turned inside out, is entered, which does no harm. */
OP uint32_t pktrt__box_test_rays(const pktrt__batch *b, uint32_t r, const v8 lo[3], const v8 hi[3]) {
  v8 n = vload(b->wn + r), f = vload(b->wf + r);
  UNROLL for (int a = 0; a < 3; a++) {
    const v8 rd = vload(b->rd[a] + r), l = vmul(lo[a], rd), h = vmul(hi[a], rd);
    n = vmax(vsub(vmin(l, h), vload(b->as.slab.cn[a] + r)), n);
    f = vmin(vsub(vmax(l, h), vload(b->as.slab.cf[a] + r)), f);
  }
  return mbits(vle(n, f));
}

/* Returns the rays of [base, base + 64) in `mask` that may hit a box. */
PKTRT__NOINLINE uint64_t pktrt__box_test_packet(const pktrt__batch *b, uint32_t base, uint64_t mask, const float lo[3],
                                                const float hi[3]) {
  const v8 l[3] = {vset(lo[0]), vset(lo[1]), vset(lo[2])}, h[3] = {vset(hi[0]), vset(hi[1]), vset(hi[2])};
  uint64_t result = 0;
  for (uint32_t i = 0; i < 64; i += 8)
    if (mask >> i & 0xFF) result |= (uint64_t)pktrt__box_test_rays(b, base + i, l, h) << i;
  return result & mask;
}

/* >>frustum ----------------------------------------------------------------------------------------------------------
   Up to 64 rays of one octant with the same main axis k and its sign s, whatever their origins: four planes around
   all of them cull whole subtrees, one box test per child tells which rays go on, thin packets go on as streams.

   A ray is u(W) = C + G W, where W is the depth along s k from the reference point, common to all rays. At W = 0 and at
   W = Y, the far end of the scene or of the rays, take the largest and smallest u over the rays: straight lines through
   these bound every ray between 0 and Y, because each ray is a straight line, be they crossing or diverging. Shadow
   rays that end at one light get a cone.

       u |        ___---  upper(W)
         |  __----   /
         |--   rays / <- box
         |----__   /
         |      ---\___  lower(W)
         +--------------------> W
       0                    Y                                                                                    */

/* Tells whether the rays in mask have one origin. */
OP bool pktrt__frustum_common_origin(const pktrt__frustum *f, const pktrt__batch *b, uint64_t mask) {
  const vf x = fset(b->o[0][f->first]), y = fset(b->o[1][f->first]), z = fset(b->o[2][f->first]);
  uint64_t same = 0;
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t r = f->base + i;
    const mf xy = fmand(feq(fload(b->o[0] + r), x), feq(fload(b->o[1] + r), y));
    same |= (uint64_t)fbits(fmand(xy, feq(fload(b->o[2] + r), z))) << i;
  }
  return !(mask & ~same);
}

/* Computes the reference point, rho and the padding from the box of the origins of the rays in mask; if `ends`, also how far
   the farthest ends. */
OP void pktrt__frustum_origins(pktrt__frustum *f, const pktrt__batch *b, uint64_t mask, bool ends) {
  const float *o[3] = {b->o[f->ku] + f->base, b->o[f->kv] + f->base, b->o[f->k] + f->base};
  const vf inf = fset(INFINITY), ninf = fset(-INFINITY);
  vf lo[3] = {inf, inf, inf}, hi[3] = {ninf, ninf, ninf}, pad = fset(0), end = ninf;
  f->common = pktrt__frustum_common_origin(f, b, mask), f->far_ = INFINITY;
  if (f->common) {
    const uint32_t i = f->first - f->base;
    f->ref[0] = o[0][i], f->ref[1] = o[1][i], f->ref[2] = f->sign * o[2][i], f->pad = b->pad[f->first];
    return;
  }
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t bits = (uint32_t)(mask >> i) & ((1u << FW) - 1);
    if (!bits) continue;
    const mf m = ffrom(bits);
    UNROLL for (int a = 0; a < 3; a++) {
      const vf x = a == 2 ? fmul(fset(f->sign), fload(o[a] + i)) : fload(o[a] + i);
      lo[a] = fmin_masked(m, lo[a], x);
      hi[a] = fmax_masked(m, hi[a], x);
      if (a == 2 && ends) end = fmax_masked(m, end, fadd(x, fload(b->wf + f->base + i)));
    }
    pad = fmax_masked(m, pad, fload(b->pad + f->base + i));
  }
  float rho = 0;
  UNROLL for (int a = 0; a < 3; a++) {
    const float l = fhmin(lo[a]), h = fhmax(hi[a]);
    f->ref[a] = a == 2 || l == h ? l : 0.5f * l + 0.5f * h;
    rho = pktrt__maxf(rho, pktrt__maxf(h - f->ref[a], f->ref[a] - l));
  }
  f->pad = fhmax(pad) + PKTRT__PAD_RHO * rho;
  if (ends) f->far_ = fhmax(end) - f->ref[2];
}

/* Computes the four planes around the rays from the extremes of C, and of C + G Y; `ends`: rays end at Y. */
OP void pktrt__frustum_planes(pktrt__frustum *f, const pktrt__batch *b, uint64_t mask, const bool common, bool ends) {
  const vf inf = fset(INFINITY), ninf = fset(-INFINITY), s = fset(f->sign);
  const uint32_t axis[2] = {f->ku, f->kv};
  vf n0[2] = {inf, inf}, n1[2] = {inf, inf}, x0[2] = {ninf, ninf}, x1[2] = {ninf, ninf};
  vf wmin = inf, wmax = ninf, depth = fset(0);
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t bits = (uint32_t)(mask >> i) & ((1u << FW) - 1), r = f->base + i;
    if (!bits) continue;
    const mf m = ffrom(bits);
    const vf ow = common ? fset(0) : fsub(fmul(s, fload(b->o[f->k] + r)), fset(f->ref[2]));
    const vf wn = fadd(ow, fload(b->wn + r)), wf = fadd(ow, fload(b->wf + r));
    fstore(f->ow + i, ow);
    if (!common) depth = fmax_masked(m, depth, ow);
    wmin = fmin_masked(m, wmin, wn);
    wmax = fmax_masked(m, wmax, wf);
    UNROLL for (int a = 0; a < 2; a++) {
      const vf g = fmul(s, fload(b->slope[a] + r));
      const vf c = common ? fset(0) : fsub(fsub(fload(b->o[axis[a]] + r), fset(f->ref[a])), fmul(g, ow));
      const vf end = ffma(g, fset(f->far_), c);
      if (!common) n0[a] = fmin_masked(m, n0[a], c), x0[a] = fmax_masked(m, x0[a], c);
      n1[a] = fmin_masked(m, n1[a], end), x1[a] = fmax_masked(m, x1[a], end);
    }
  }
  f->wmin = fhmin(wmin), f->wmax = fhmax(wmax), f->depth = common ? 0 : fhmax(depth);
  float extreme[2][4];
  UNROLL for (int a = 0; a < 2; a++) { /* a common origin is the reference point, and C is 0 */
    extreme[a][0] = common ? 0 : fhmax(x0[a]), extreme[a][1] = common ? 0 : fhmin(n0[a]);
    extreme[a][2] = fhmax(x1[a]), extreme[a][3] = fhmin(n1[a]);
  }
  pktrt__frustum_bound(f, extreme, ends);
}

/* Makes the frustum of rays [base, base + 64) in mask, all of one axis and octant; `ends`: they may end together. */
PKTRT__NOINLINE void pktrt__frustum_setup(pktrt__frustum *f, const pktrt_scene *scene, const pktrt__batch *b,
                                          uint32_t base, uint64_t mask, bool ends) {
  f->base = base, f->first = base + pktrt__lowest_bit(mask);
  const uint32_t k = b->axis[f->first];
  f->k = k, f->ku = (k + 1) % 3, f->kv = (k + 2) % 3;
  f->octant = b->octant[f->first];
  const float sign = f->sign = f->octant >> k & 1 ? -1.0f : 1.0f;
  pktrt__frustum_origins(f, b, mask, ends);
  const float exit_ = (sign > 0 ? scene->hi[k] : -scene->lo[k]) - f->ref[2];
  ends = f->far_ < 8 * exit_; /* not at a light so far away that extents there are what is rounded */
  if (!ends) f->far_ = exit_;
  f->far_ = pktrt__maxf(f->far_ * (1 + PKTRT__SLACK(end) * 16 * PKTRT__EPS) + PKTRT__SLACK(end) * f->pad, 1e-30f);
  if (f->common) pktrt__frustum_planes(f, b, mask, true, false);
  else pktrt__frustum_planes(f, b, mask, false, ends);
  for (uint32_t i = 0; i < 64; i++) f->list[i] = (uint8_t)(base + i);
}

/* Finds the earliest and latest time of the rays in mask, as weights of the segment's second key. */
PKTRT__NOINLINE void pktrt__frustum_times(pktrt__frustum *f, const pktrt__batch *b, uint64_t mask) {
  vf lo = fset(1), hi = fset(0);
  for (uint32_t i = 0; i < 64; i += FW) {
    const mf m = ffrom((uint32_t)(mask >> i) & ((1u << FW) - 1));
    const vf t = fload(b->tb + f->base + i);
    lo = fmin_masked(m, lo, t), hi = fmax_masked(m, hi, t);
  }
  f->tb[0] = fhmin(lo), f->tb[1] = fhmax(hi);
}

/* Updates the farthest depth at which any ray of mask can still find its answer. */
OP void pktrt__frustum_update_depth(pktrt__frustum *f, const pktrt__batch *b, uint64_t mask) {
  vf w = fset(-INFINITY);
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t bits = (uint32_t)(mask >> i) & ((1u << FW) - 1);
    if (!bits) continue;
    const vf wf = fadd(fload(f->ow + i), fload(b->wf + f->base + i));
    w = fmax_masked(ffrom(bits), w, wf);
  }
  f->wmax = fhmax(w);
}

/* Returns the smallest (which = 0) or largest (1) position of a plane over the packet's times; *other: the opposite. */
OP v8 pktrt__frustum_swept_plane(const pktrt__frustum *f, const float *p0, const float *p1, const int which,
                                 const bool moving, v8 *other) {
  if (!moving) return *other = vload(p0);
  const v8 k0 = vload(p0), way = vsub(vload(p1), k0);
  const v8 first = vfma(vset(f->tb[0]), way, k0), last = vfma(vset(f->tb[1]), way, k0);
  *other = which ? vmin(first, last) : vmax(first, last);
  return which ? vmax(first, last) : vmin(first, last);
}

/* Returns the children of a node that reach into the frustum, with their near depths *entry, and in *whole those that
   all rays enter, if their depths reach that far. */
OP uint32_t pktrt__frustum_cull_children(const pktrt__frustum *f, const float *p0, const float *p1, const bool moving,
                                         v8 *entry, uint32_t *whole) {
  const uint32_t back = f->sign < 0, wl = 16 * f->k + 8 * back, wh = 16 * f->k + 8 * (1 - back);
  const v8 s = vset(f->sign);
  v8 late, other; /* late: the farthest position of the face by which rays enter */
  v8 w0 = vfms(pktrt__frustum_swept_plane(f, p0 + wl, p1 + wl, back != 0, moving, &late), s, vset(f->ref[2] + f->pad));
  v8 w1 = vfms(pktrt__frustum_swept_plane(f, p0 + wh, p1 + wh, back == 0, moving, &other), s, vset(f->ref[2] - f->pad));
  m8 keep = mand(vle(vset(f->wmin), w1), vle(w0, vset(f->wmax)));
  *entry = w0;
  w0 = vmax(w0, vset(0)), w1 = vmin(w1, vset(f->far_));
  late = moving ? vmax(vfms(late, s, vset(f->ref[2] + f->pad)), vset(0)) : w0;
  m8 in = keep;
  UNROLL for (int a = 0; a < 2; a++) {
    const uint32_t lo = 16 * (a ? f->kv : f->ku), hi = lo + 8;
    v8 inner[2];
    const v8 l = vsub(pktrt__frustum_swept_plane(f, p0 + lo, p1 + lo, 0, moving, &inner[0]), vset(f->ref[a] + f->pad));
    const v8 h = vsub(pktrt__frustum_swept_plane(f, p0 + hi, p1 + hi, 1, moving, &inner[1]), vset(f->ref[a] - f->pad));
    const float up = f->b[2 * a], down = f->b[2 * a + 1];
    const v8 upper = vfma(vset(up), up > 0 ? w1 : w0, vset(f->a[2 * a]));
    const v8 lower = vfma(vset(down), down > 0 ? w0 : w1, vset(f->a[2 * a + 1]));
    keep = mand(keep, mand(vle(l, upper), vle(lower, h)));
    const v8 li = moving ? vsub(inner[0], vset(f->ref[a] + f->pad)) : l;
    const v8 hi_ = moving ? vsub(inner[1], vset(f->ref[a] - f->pad)) : h;
    /* a packet that is within the face of a box at all times enters it as a whole */
    in = mand(in, mand(vle(vfma(vset(up), late, vset(f->a[2 * a])), hi_),
                       vle(li, vfma(vset(down), late, vset(f->a[2 * a + 1])))));
  }
  *whole = mbits(in);
  return mbits(keep);
}
/* Culls the children of a moving node. WHY not inlined: less code, and as fast. */
PKTRT__NOINLINE uint32_t pktrt__frustum_cull_children_moving(const pktrt__frustum *f, const float *p0, const float *p1,
                                                             v8 *entry, uint32_t *whole) {
  return pktrt__frustum_cull_children(f, p0, p1, true, entry, whole);
}

/* Returns the rays of mask that may hit one child, whose planes start at p0 and p1 (stride 8 floats). WHY all vectors,
   also those without rays: a branch costs more. */
OP uint64_t pktrt__frustum_test_child(const pktrt__frustum *f, const pktrt__batch *b, const float *p0, const float *p1,
                                      uint64_t mask, const bool moving) {
  const uint32_t nx = f->octant << 3 & 8, ny = 16 + (f->octant << 2 & 8), nz = 32 + (f->octant << 1 & 8);
  const uint32_t near_[3] = {nx, ny, nz}, far_[3] = {nx ^ 8, ny ^ 8, nz ^ 8};
  uint64_t result = 0;
  UNROLL_WIDE for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t bits = (uint32_t)(mask >> i) & ((1u << FW) - 1), r = f->base + i;
    vf n = fload(b->wn + r), x = fload(b->wf + r);
    UNROLL for (int a = 0; a < 3; a++) {
      const vf rd = fload(b->rd[a] + r);
      vf l = fset(p0[near_[a]]), h = fset(p0[far_[a]]);
      if (moving) {
        const vf t = fload(b->tb + r);
        l = ffma(t, fset(p1[near_[a]] - p0[near_[a]]), l);
        h = ffma(t, fset(p1[far_[a]] - p0[far_[a]]), h);
      }
      n = fmax_(ffms(l, rd, fload(b->as.slab.cn[a] + r)), n);
      x = fmin_(ffms(h, rd, fload(b->as.slab.cf[a] + r)), x);
    }
    result |= (uint64_t)(fbits(fle(n, x)) & bits) << i;
  }
  return result;
}
/* Does so for rays of one origin: o +- D, which is taken from the planes, is the same for all, see >>exactness. */
OP uint64_t pktrt__frustum_test_child_template(const pktrt__frustum *f, const pktrt__batch *b, const float *p0,
                                               const float *p1, uint64_t mask, const bool moving) {
  vf l0[3], h0[3], l_way[3], h_way[3];
  uint64_t result = 0;
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    const uint32_t back = f->octant >> a & 1, n = 16 * a + 8 * back, x = n ^ 8;
    const float o = b->o[a][f->first], pad = back ? -b->pad[f->first] : b->pad[f->first];
    l0[a] = fset(p0[n] - (o + pad)), h0[a] = fset(p0[x] - (o - pad));
    if (moving) l_way[a] = fset(p1[n] - p0[n]), h_way[a] = fset(p1[x] - p0[x]);
  }
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t bits = (uint32_t)(mask >> i) & ((1u << FW) - 1), r = f->base + i;
    vf n = fload(b->wn + r), x = fload(b->wf + r);
    UNROLL for (int a = 0; a < 3; a++) {
      const vf rd = fload(b->rd[a] + r), t = fload(b->tb + r);
      n = fmax_(fmul(moving ? ffma(t, l_way[a], l0[a]) : l0[a], rd), n);
      x = fmin_(fmul(moving ? ffma(t, h_way[a], h0[a]) : h0[a], rd), x);
    }
    result |= (uint64_t)(fbits(fle(n, x)) & bits) << i;
  }
  return result;
}
/* Does so at rest, and of moving nodes for rays of any origins. WHY not inlined: less code, and as fast. */
PKTRT__NOINLINE uint64_t pktrt__frustum_test_child_from(const pktrt__frustum *f, const pktrt__batch *b, const float *p0,
                                                        uint64_t mask) {
  return pktrt__frustum_test_child_template(f, b, p0, p0, mask, false);
}
PKTRT__NOINLINE uint64_t pktrt__frustum_test_child_moving(const pktrt__frustum *f, const pktrt__batch *b,
                                                          const float *p0, const float *p1, uint64_t mask) {
  return f->common ? pktrt__frustum_test_child_template(f, b, p0, p1, mask, true)
                   : pktrt__frustum_test_child(f, b, p0, p1, mask, true);
}

/* Values of the triangles of a block that all rays of a packet share. */
typedef struct pktrt__frustum_corners {
  PKTRT__ALIGN64 float p[3][3][8]; /* of pointed frusta: corners relative to the apex, [corner][u, v, k][lane] */
  float range[8], far_[8];         /* depths: at least the range over corners, the largest |z| */
  float error[8];                  /* of edge functions, of all rays */
} pktrt__frustum_corners;

/* Returns the triangles at rest that all rays of a pointed frustum miss beyond one edge. Relative to the apex and with
   slopes S0 + s, x = X - s W in the corners' X = p_u - S0 W, and so y: the product s_u s_v cancels in U = (x2 y1 - y2 x1)
   = (X2 Y1 - Y2 X1) + s_u (Y2 W1 - W2 Y1) + s_v (W2 X1 - X2 W1), linear over the packet. A triangle is missed by all if
   one edge function is below 0 for all rays, and one is above. What rounding may do: X here is within 3 eps M of p_u - S
   W, where pad >= 16 eps M, so that U moves by at most pad (|x| + |y|); and six products of at most (|X| + h |W|) (|Y|
   + h |W|) are rounded and summed. h: the slopes are those of planes, 4 eps wider.
   Rays that end together have their apex there and miss it by q at most: by half their extent, and by what rounds it and
   corners relative to it, less than 2 pad + 4 eps |apex|. Then U moves by 2 q (|x| + |y|) + 2 q^2, for which the padding
   is 4 q; their slopes are bounded by extents at both ends, each of which is within pad, and padded by 2 pad each. */
PKTRT__NOINLINE uint32_t pktrt__frustum_cull_by_edges(const pktrt__frustum *f, pktrt__frustum_corners *c) {
  const v8 s = vset(f->sign);
  v8 x[3], y[3], w[3], m[2], h[2], least = vset(INFINITY), most = vset(-INFINITY);
  UNROLL for (int a = 0; a < 2; a++) {
    const float up = f->slope[2 * a], down = f->slope[2 * a + 1];
    h[a] = vset(0.5f * (up - down) + 4 * PKTRT__EPS * (fabsf(up) + fabsf(down)));
    m[a] = vset(f->apex_pad);
    UNROLL for (int i = 0; i < 3; i++) {
      w[i] = vmul(vload(c->p[i][2]), s);
      const v8 q = vsub(vload(c->p[i][a]), vmul(vset(0.5f * (up + down)), w[i]));
      *(a ? &y[i] : &x[i]) = q;
      m[a] = vmax(m[a], vfma(h[a], vabs(w[i]), vabs(q)));
    }
  }
  UNROLL for (int i = 0; i < 3; i++) {
    const int j = (i + 2) % 3, k = (i + 1) % 3; /* U: corners 2, 1; V: 0, 2; W: 1, 0 */
    const v8 e = vsub(vmul(x[j], y[k]), vmul(y[j], x[k]));
    const v8 eu = vabs(vsub(vmul(y[j], w[k]), vmul(w[j], y[k]))), ev = vabs(vsub(vmul(w[j], x[k]), vmul(x[j], w[k])));
    const v8 swing = vfma(h[0], eu, vmul(h[1], ev));
    least = vmin(least, vadd(e, swing));
    most = vmax(most, vsub(e, swing));
  }
  const v8 error =
      vfma(vmul(m[0], m[1]), vset(PKTRT__SLACK(sides) * 32 * PKTRT__EPS),
           vfma(vadd(m[0], m[1]), vset(PKTRT__SLACK(sides) * f->apex_pad), vset(PKTRT__SLACK(sides) * FLT_MIN)));
  return mbits(mand(vlt(vadd(least, error), vset(0)), vlt(error, most)));
}

/* The extents of triangles, over corners and times: in depth, and in u - b W and v - b W of the planes. */
typedef struct pktrt__frustum_reach {
  v8 wlo, whi, low[2], high[2];
} pktrt__frustum_reach;
OP pktrt__frustum_reach pktrt__frustum_reach_none(void) {
  const v8 inf = vset(INFINITY), ninf = vset(-INFINITY);
  const pktrt__frustum_reach nothing = {inf, ninf, {inf, inf}, {ninf, ninf}};
  return nothing;
}
OP void pktrt__frustum_reach_add(pktrt__frustum_reach *r, const pktrt__frustum *f, const v8 q[3]) {
  const v8 w = vfms(q[2], vset(f->sign), vset(f->ref[2]));
  r->wlo = vmin(r->wlo, w), r->whi = vmax(r->whi, w);
  UNROLL for (int a = 0; a < 2; a++) {
    const v8 u = vsub(q[a], vset(f->ref[a]));
    r->low[a] = vmin(r->low[a], vsub(u, vmul(vset(f->b[2 * a]), w)));
    r->high[a] = vmax(r->high[a], vsub(u, vmul(vset(f->b[2 * a + 1]), w)));
  }
}
/* Returns the triangles that reach into the frustum. */
OP uint32_t pktrt__frustum_reach_inside(const pktrt__frustum_reach *r, const pktrt__frustum *f) {
  m8 in = mand(vle(vset(f->wmin - f->pad), r->whi), vle(r->wlo, vset(f->wmax + f->pad)));
  UNROLL for (int a = 0; a < 2; a++) in =
      mand(in, mand(vle(r->low[a], vset(f->a[2 * a] + f->pad)), vle(vset(f->a[2 * a + 1] - f->pad), r->high[a])));
  return mbits(in);
}

/* Bounds |x| and |y| of triangles over the rays of a packet: where they lie beyond all origins, by how far they are away
   from the planes, and, where they lie beyond Y, by how far rays may be beyond these; else by 2 M, of which 2 pad / (16
   eps) is no less. No hit was found that needs what lies beyond Y: one before Y leaves corners there little weight. */
OP void pktrt__frustum_reach_size(const pktrt__frustum_reach *r, const pktrt__frustum *f, v8 size[2]) {
  const v8 behind = vmax(vsub(r->whi, vset(f->far_)), vset(0));
  UNROLL for (int a = 0; a < 2; a++) {
    const v8 from = vsub(r->low[a], vset(f->a[2 * a])), to = vsub(r->high[a], vset(f->a[2 * a + 1]));
    const float leave = pktrt__maxf(f->slope[2 * a] - f->b[2 * a], f->b[2 * a + 1] - f->slope[2 * a + 1]);
    const v8 beyond = vfma(behind, vset(leave), vadd(vmax(vabs(from), vabs(to)), vset(4 * f->pad)));
    size[a] = vsel(vlt(vset(f->pad), r->wlo), beyond, vset(f->pad * (2 / PKTRT__PAD_M)));
  }
}

/* Returns the triangles of a block at rest that reach into the frustum, and computes their shared values. */
STEP uint32_t pktrt__frustum_cull_triangles(const pktrt__frustum *f, const float *k0, pktrt__frustum_corners *corners) {
  const uint32_t axis[3] = {f->ku, f->kv, f->k};
  pktrt__frustum_reach reach = pktrt__frustum_reach_none();
  UNROLL for (int c = 0; c < 3; c++) {
    v8 q[3];
    UNROLL for (int j = 0; j < 3; j++) q[j] = vload(k0 + 24 * (uint32_t)c + 8 * axis[j]);
    if (f->pointed) UNROLL for (int j = 0; j < 3; j++) vstore(corners->p[c][j], vsub(q[j], vset(f->apex[j])));
    pktrt__frustum_reach_add(&reach, f, q);
  }
  const v8 far_ = vadd(vmax(vabs(reach.wlo), vabs(reach.whi)), vset(f->depth + f->pad));
  v8 size[2];
  pktrt__frustum_reach_size(&reach, f, size);
  vstore(corners->range, vadd(vsub(reach.whi, reach.wlo), vset(f->pad)));
  vstore(corners->far_, far_);
  vstore(corners->error, PKTRT__EDGE_ERROR(v, size[0], size[1], far_));
  uint32_t lanes = pktrt__frustum_reach_inside(&reach, f);
  if (f->pointed && lanes) lanes &= ~pktrt__frustum_cull_by_edges(f, corners);
  return lanes;
}

/* Makes a triangle the closest hit of those of rays r, r+1, ... in `taken`, as pktrt__batch_set_hit does. */
OP void pktrt__frustum_set_hits(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t taken, vf lo,
                                vf hi, uint32_t id, uint32_t slot) {
  const mf m = ffrom(taken);
  fstore_masked(b->sf + r, m, lo);
  fstore_masked(b->wf + r, m, hi);
  fstore_masked_u32(b->id + r, m, id);
  fstore_masked_u32(b->slot + r, m, slot);
  fstore_masked_u32(b->bvh + r, m, seg->bvh);
}

/* The plane of a triangle as eight rays have it: a corner, the normal, and what their errors are measured by. */
typedef struct pktrt__frustum_plane8 {
  d8 p[3], n[3], size;
} pktrt__frustum_plane8;

/* Values of one triangle that all rays of a packet share. */
typedef struct pktrt__tri_common {
  uint32_t id, slot;
  float range, far_, error;    /* as in pktrt__frustum_corners */
  bool planar;                 /* the plane is known, as it is the same for all rays */
  pktrt__frustum_plane8 plane; /* unset before */
  pktrt_counts *counts;        /* NULL: do not count */
} pktrt__tri_common;

/* One triangle as eight rays of a frustum see it: corners, origins and directions, the rays' main axis first. Returns whether
   it moves. */
typedef struct pktrt__frustum_view8 {
  v8 p[3][3], o[3], d[3];
} pktrt__frustum_view8;
OP void pktrt__frustum_see_rays8(const pktrt__batch *b, uint32_t r, const uint32_t *k, pktrt__frustum_view8 *s) {
  for (int i = 0; i < 3; i++) s->o[i] = vload(b->o[k[i]] + r), s->d[i] = vload(b->d[k[i]] + r);
}
OP bool pktrt__frustum_see8(const pktrt__bvh_segment *seg, const pktrt__batch *b, uint32_t r, uint32_t slot,
                            const uint32_t *k, pktrt__frustum_view8 *s) {
  const pktrt__block *block = pktrt__segment_block(seg, slot / 8, true);
  const float *k0 = pktrt__segment_vertices(seg, block, 0, true) + slot % 8;
  const float *k1 = pktrt__segment_vertices(seg, block, 1, true) + slot % 8;
  const bool moving = k0 != k1; /* at rest weights 1 and 0 give the same bits */
  const v8 tb = moving ? vload(b->tb + r) : vset(0), ta = vsub(vset(1), tb);
  for (uint32_t i = 0; i < 9; i++)
    s->p[i / 3][i % 3] =
        vadd(vmul(ta, vset(k0[24 * (i / 3) + 8 * k[i % 3]])), vmul(tb, vset(k1[24 * (i / 3) + 8 * k[i % 3]])));
  pktrt__frustum_see_rays8(b, r, k, s);
  return moving;
}

#if PKTRT__WITH_V8_REGISTERS /* or eight vectors of doubles would not fit: each ray does that by itself */
/* Finds the plane of a triangle, from corners at the rays' times. */
OP void pktrt__frustum_plane_of(const pktrt__frustum_view8 *s, pktrt__frustum_plane8 *plane) {
  d8 e[2][3];
  UNROLL for (int a = 0; a < 3; a++) {
    const d8 p = plane->p[a] = dfrom(s->p[0][a]);
    e[0][a] = dsub(dfrom(s->p[1][a]), p), e[1][a] = dsub(dfrom(s->p[2][a]), p);
  }
  UNROLL for (int a = 0, b = 1, c = 2; a < 3; b = c, c = a++) plane->n[a] =
      dsub(dmul(e[0][b], e[1][c]), dmul(e[0][c], e[1][b]));
  plane->size = dmul(dmul(pktrt__vec_dmax_abs3(e[0][0], e[0][1], e[0][2]), dset(64 * PKTRT__EPS2)),
                     pktrt__vec_dmax_abs3(e[1][0], e[1][1], e[1][2]));
}
/* Does what pktrt__exact_is_apart does. */
PKTRT__NOINLINE uint32_t pktrt__frustum_apart8(const pktrt__frustum_plane8 *plane, const pktrt__frustum_view8 *s,
                                               v8 tmin, v8 tmax) {
  d8 from[3], along[3];
  UNROLL for (int a = 0; a < 3; a++) from[a] = dsub(plane->p[a], dfrom(s->o[a])), along[a] = dfrom(s->d[a]);
  const d8 *n = plane->n, size = plane->size, zero = dset(0), wrong = dmul(size, dabs(along[0]));
  const d8 most = dmul(size, pktrt__vec_dmax_abs3(from[0], from[1], from[2])), end = dfrom(tmax);
  const d8 f = dadd(dadd(dmul(n[0], from[0]), dmul(n[1], from[1])), dmul(n[2], from[2]));
  const d8 g = dadd(dadd(dmul(n[0], along[0]), dmul(n[1], along[1])), dmul(n[2], along[2]));
  const d8 over = dsub(f, dmul(end, g));
  const m8 before = mand(dlt(dmul(f, g), zero), dlt(most, dabs(f)));
  const m8 after = mand(dlt(zero, dmul(over, g)), dlt(dadd(most, dmul(dabs(end), wrong)), dabs(over)));
  return mbits(dlt(wrong, dabs(g))) & ((mbits(before) & mbits(vle(vset(0), tmin))) | mbits(after));
}

/* What doubles tell of it: t, where calm; lanes that cross it, that do not, and whose t, u and v are calm. */
typedef struct pktrt__frustum_exact8 {
  v8 t;
  uint32_t crossed, missed, calm;
} pktrt__frustum_exact8;
PKTRT__NOINLINE void pktrt__frustum_solve8(const pktrt__frustum_view8 *s, pktrt__frustum_exact8 *out) {
  d8 x[3], y[3], z[3];
  UNROLL for (int c = 0; c < 3; c++) pktrt__exact_shear8(s->p[c], s->o, s->d, &x[c], &y[c], &z[c]);
  const d8 dk = dfrom(s->d[0]), zero = dset(0);
  const pktrt__exact_edges8 e = pktrt__exact_edge_functions8(x, y, z);
  d8 error;
  out->calm = pktrt__exact_calm8(&e, x, y, z, dk, &error);
  const d8 least = dsub(zero, dmax(dsub(zero, e.u), dmax(dsub(zero, e.v), dsub(zero, e.w))));
  const d8 most = dmax(e.u, dmax(e.v, e.w)), minus = dsub(zero, error), scale = dmul(e.det, dk);
  out->crossed = mbits(mor(dlt(error, least), dlt(most, minus)));
  out->missed = mbits(mand(dlt(least, minus), dlt(error, most)));
  out->t = dto(dmul(e.depth, ddiv(dset(1), scale)));
}

/* Tells which of the rays in `same`, whose t of a triangle are known, hit it nearer than the one they share as closest hit so
   far, or as near with a lower index; takes those it cannot tell from *same. */
OP uint32_t pktrt__frustum_nearer8(const pktrt__bvh_segment *seg, const pktrt__batch *b, uint32_t r, v8 t, uint32_t id,
                                   const uint32_t *k, uint32_t *same) {
  const uint32_t first = r + pktrt__lowest_bit(*same);
  pktrt__frustum_view8 s;
  pktrt__frustum_exact8 e;
  pktrt__frustum_see8(seg, b, r, b->slot[first], k, &s);
  pktrt__frustum_solve8(&s, &e);
  *same &= e.calm;
  return *same & (mbits(vlt(t, e.t)) | (id < b->id[first] ? mbits(veq(t, e.t)) : 0));
}
#endif

/* Runs the exact test of eight rays of a frustum, for those in *open, as far as doubles or a grid decide it; returns those
   that are hit, leaves the undecided open. WHY: many rays begin or end at a surface, which is told first, or meet two that
   coincide. */
PKTRT__NOINLINE uint32_t pktrt__frustum_exact_test8(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r,
                                                    uint32_t *open, pktrt__tri_common *tri) {
  pktrt__frustum_view8 s;
  uint32_t crossed = 0, maybe = *open, taken = 0;
  const uint32_t *k = pktrt__axes[b->axis[r + pktrt__lowest_bit(*open)]], id = tri->id, slot = tri->slot;
#if PKTRT__WITH_V8_REGISTERS
  pktrt__frustum_exact8 e;
  const bool planar = tri->planar;
  if (planar) pktrt__frustum_see_rays8(b, r, k, &s);
  else tri->planar = !pktrt__frustum_see8(seg, b, r, slot, k, &s), pktrt__frustum_plane_of(&s, &tri->plane);
  maybe &= ~pktrt__frustum_apart8(&tri->plane, &s, vload(b->tmin + r), vload(b->tmax + r));
  if (!maybe) return *open = 0;
  if (planar) pktrt__frustum_see8(seg, b, r, slot, k, &s);
  pktrt__frustum_solve8(&s, &e);
  crossed = e.crossed, maybe &= ~e.missed;
#else
  pktrt__frustum_see8(seg, b, r, slot, k, &s);
#endif
  uint32_t even = maybe & ~crossed;
  if (even && (even &= pktrt__tri_directions_on_grid(s.d)) != 0) {
    float corners[72];
    for (uint32_t i = 0; i < 9; i++) vstore(corners + 8 * i, s.p[i / 3][i % 3]);
    pktrt__tri_decide_on_grid(corners, pktrt__axes[0], s.o, s.d, even, &maybe, &crossed);
  }
#if PKTRT__WITH_V8_REGISTERS
  const v8 far_ = vmul(e.t, vabs(s.d[0])), slack = vadd(vmul(vabs(far_), vset(PKTRT__PAD_DEPTH)), vload(b->tiny + r));
  const uint32_t within = mbits(mand(vlt(vload(b->tmin + r), e.t), vlt(e.t, vload(b->tmax + r))));
  const uint32_t inside = maybe & crossed & e.calm;
  taken = inside & within & pktrt__lanes_unhit(b->slot + r);
  uint32_t told = taken | (inside & ~within);
  for (uint32_t rest = inside & ~told & veq_u32(b->bvh + r, seg->bvh); rest;) {
    uint32_t same = rest & veq_u32(b->slot + r, b->slot[r + pktrt__lowest_bit(rest)]);
    rest &= ~same;
    taken |= pktrt__frustum_nearer8(seg, b, r, e.t, id, k, &same);
    told |= same;
  }
  pktrt__frustum_set_hits(seg, b, r, taken, fwide(vsub(far_, slack)), fwide(vadd(far_, slack)), id, slot);
  maybe &= ~told;
#else
  (void)id;
#endif
  *open = maybe;
  return taken;
}

/* Values of one triangle for a vector of rays: edge functions, depths of corners, largest |x| and |y|. */
typedef struct pktrt__frustum_edges {
  vf e[3], z[3], xs, ys;
} pktrt__frustum_edges;

/* Makes the triangle the closest hit of those of a vector of rays that hit nothing nearer so far; returns them. */
PKTRT__NOINLINE uint32_t pktrt__frustum_accept(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r,
                                               uint32_t bits, const pktrt__frustum_edges *s, pktrt__tri_common *tri) {
  const vf e[3] = {s->e[0], s->e[1], s->e[2]}, z[3] = {s->z[0], s->z[1], s->z[2]};
  const vf zero = fset(0), dk = fload(b->dk + r), edge = PKTRT__EDGE_ERROR(f, s->xs, s->ys, fset(tri->far_));
  const vf least = fmin_(e[0], fmin_(e[1], e[2])), most = fmax_(e[0], fmax_(e[1], e[2])), minus = fsub(zero, least);
  const vf det = fadd(fadd(e[0], e[1]), e[2]), inverse = fdiv(fset(1), det), size = fabs_(det);
  const vf sum = ffma(fmul(e[0], inverse), z[0], ffma(fmul(e[1], inverse), z[1], fmul(fmul(e[2], inverse), z[2])));
  const vf depth = fsel(flt(dk, zero), fsub(zero, sum), sum);
  const vf error =
      ffma(fmul(edge, fabs_(inverse)), fset(tri->range), PKTRT__DEPTH_REACH(f, fset(tri->far_), fload(b->tiny + r)));
  const mf known = fmand(flt(fmul(fset(PKTRT__LEAST_DET), edge), size), fle(size, fset(FLT_MAX)));
  const vf bound = fsel(known, error, fset(INFINITY)), lo = fsub(depth, bound), hi = fadd(depth, bound);
  const mf beyond = fmor(flt(fload(b->wf + r), lo), flt(hi, fload(b->wn + r))); /* NaN leaves it open */
  bits &= ~fbits(fmor(beyond, flt(edge, fmin_(most, minus))));
  const uint32_t sure = fbits(flt(edge, fmax_(least, fsub(zero, most))));
  uint32_t taken = bits & sure & fbits(fmand(flt(fload(b->sn + r), lo), flt(hi, fload(b->sf + r))));
  uint32_t open = bits & ~taken;
  for (uint32_t i = 0; open && i < FW; i += 8) /* a split triangle, again */
    open &= ~((veq_u32(b->id + r + i, tri->id) & ~pktrt__lanes_unhit(b->slot + r + i) & 0xFF) << i);
  if (tri->counts)
    tri->counts->canonical_tests += pktrt__popcount(bits), tri->counts->settlings += pktrt__popcount(open);
  pktrt__frustum_set_hits(seg, b, r, taken, lo, hi, tri->id, tri->slot);
  for (uint32_t i = 0; (PKTRT__WITH_V8_REGISTERS ? open : open & ~sure) && i < FW; i += 8) {
    const uint32_t some = open >> i & 0xFF;
    uint32_t left = some;
    if (some) taken |= pktrt__frustum_exact_test8(seg, b, r + i, &left, tri) << i;
    open &= ~((some & ~left) << i);
  }
  for (; PKTRT__UNLIKELY(open); open &= open - 1)
    if (pktrt__exact_test(seg, b, r + pktrt__lowest_bit(open), tri->id, tri->slot)) taken |= open & (0u - open);
  return taken;
}

/* Tests one triangle, given its sheared corners, against a vector of rays; returns those that hit it. */
OP uint32_t pktrt__frustum_filter(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t rays,
                                  const vf x[3], const vf y[3], const vf z[3], pktrt__tri_common *tri) {
  pktrt__frustum_edges s;
  s.e[0] = ffms(x[2], y[1], fmul(y[2], x[1])), s.e[1] = ffms(x[0], y[2], fmul(y[0], x[2]));
  s.e[2] = ffms(x[1], y[0], fmul(y[1], x[0]));
  const vf least = fmin_(s.e[0], fmin_(s.e[1], s.e[2])), most = fmax_(s.e[0], fmax_(s.e[1], s.e[2]));
  const uint32_t bits = rays & ~fbits(fmand(flt(least, fset(-tri->error)), flt(fset(tri->error), most)));
  if (!bits) return 0;
  UNROLL for (int i = 0; i < 3; i++) s.z[i] = z[i];
  s.xs = fmax_(fabs_(x[0]), fmax_(fabs_(x[1]), fabs_(x[2])));
  s.ys = fmax_(fabs_(y[0]), fmax_(fabs_(y[1]), fabs_(y[2])));
  return pktrt__frustum_accept(seg, b, r, bits, &s, tri);
}

/* Values of the triangles of a moving block that all rays of a packet share. */
typedef struct pktrt__frustum_motion {
  PKTRT__ALIGN64 float p[3][3][8], way[3][3][8]; /* corners at the first key, as in pktrt__frustum_corners; vectors
                                                    from there to the second */
  float error[8];                                /* B */
  float range[8], far_[8];                       /* as in pktrt__frustum_corners */
} pktrt__frustum_motion;

/* Returns the triangles of a moving block that reach into the frustum, and computes their shared values. */
OP uint32_t pktrt__frustum_cull_moving(const pktrt__frustum *f, const float *k0, const float *k1,
                                       pktrt__frustum_motion *motion) {
  const uint32_t axis[3] = {f->ku, f->kv, f->k};
  pktrt__frustum_reach reach = pktrt__frustum_reach_none();
  UNROLL for (int c = 0; c < 3; c++) {
    v8 p[3], way[3], q[3];
    UNROLL for (int j = 0; j < 3; j++) {
      const uint32_t at = 24 * (uint32_t)c + 8 * axis[j];
      p[j] = vload(k0 + at), way[j] = vsub(vload(k1 + at), p[j]);
      vstore(motion->p[c][j], p[j]);
      vstore(motion->way[c][j], way[j]);
    }
    UNROLL for (int end = 0; end < 2; end++) {
      UNROLL for (int j = 0; j < 3; j++) q[j] = vfma(vset(f->tb[end]), way[j], p[j]);
      pktrt__frustum_reach_add(&reach, f, q);
    }
  }
  v8 size[2];
  pktrt__frustum_reach_size(&reach, f, size);
  const v8 sum = vadd(vadd(size[0], size[1]), vset(2 * f->pad)), product = vmul(size[0], size[1]);
  vstore(motion->error, vfma(sum, vset(4 * f->pad), vfma(product, vset(PKTRT__PAD_MOVING), vset(PKTRT__PAD_LEAST))));
  vstore(motion->range, vadd(vsub(reach.whi, reach.wlo), vset(f->pad)));
  vstore(motion->far_, vadd(vmax(vabs(reach.wlo), vabs(reach.whi)), vset(f->depth + f->pad)));
  return pktrt__frustum_reach_inside(&reach, f);
}

/* >>leaves: rays and packets at leaf blocks ------------------------------------------------------------------------ */

/* What the filter left open of a block, for the rays of a stream in turn. */
typedef struct pktrt__stream_notes {
  PKTRT__ALIGN64 float lo[PKTRT__NOTES][8], hi[PKTRT__NOTES][8];
  uint8_t maybe[PKTRT__NOTES], inside[PKTRT__NOTES], after[PKTRT__NOTES], ray[PKTRT__NOTES];
  uint32_t n, index; /* of the block */
} pktrt__stream_notes;

#ifdef PKTRT__OTHER_TESTS /* a file with other tests of triangles in place of these; its path from here, in quotes */
#include PKTRT__OTHER_TESTS
#else
/* Tests a ray of a batch or a single ray against a leaf block; returns the lanes that pktrt__tri_record records. For
   occlusion without counts, returns 1 if anything is hit, and no lanes. */
OP uint32_t pktrt__tri_block_template(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, pktrt__single *single,
                                      uint32_t index, const pktrt__variant is) {
  if (is.occlusion && !is.stats) return pktrt__tri_any_hit(seg, b, r, single, index, is.moving);
  const pktrt__block *block = pktrt__segment_block(seg, index, is.moving);
  PKTRT__ALIGN64 float lo[8], hi[8];
  const pktrt__tri_shear q = pktrt__tri_shear_of(b, r, single, is.moving);
  pktrt__tri_candidates c = pktrt__tri_filter_block(&q, seg, block, index, true, lo, hi, is.moving);
  COUNT(triangle_tests, pktrt__popcount(pktrt__lanes_occupied(block->id)));
  return c.maybe ? pktrt__tri_record(seg, b, r, single, &c, is) : 0;
}

/* Records what is noted, and returns the rays with a nearer hit. */
PKTRT__NOINLINE uint64_t pktrt__stream_record(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list,
                                              pktrt__stream_notes *s, const bool moving) {
  const uint32_t *id = pktrt__segment_block(seg, s->index, moving)->id;
  uint64_t hit = 0;
  for (uint32_t j = 0; j < s->n; j++) {
    const uint32_t r = list[s->ray[j]];
    pktrt__tri_candidates c = {s->index, id, s->lo[j], s->hi[j], s->maybe[j], s->inside[j], s->after[j], false};
    if (pktrt__tri_record(seg, b, r, NULL, &c, pktrt__variant_of(false, moving, false, NULL)))
      hit |= (uint64_t)1 << s->ray[j];
  }
  s->n = 0;
  return hit;
}

/* Notes what the rays of mask may hit in a block; returns those with a nearer hit where there are too many for the
   notes. WHY all rays are filtered before anything is recorded: without a branch between them, the work on one ray
   overlaps that on the next. */
OP uint64_t pktrt__stream_closest_block(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list,
                                        uint64_t mask, uint32_t index, pktrt__stream_notes *s, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  uint64_t hit = 0;
  for (s->index = index;;) {
    uint32_t n = 0;
    for (; mask && n < PKTRT__NOTES; mask &= mask - 1) {
      const uint32_t i = pktrt__lowest_bit(mask), r = list[i];
      const pktrt__tri_shear q = pktrt__tri_shear_of(b, r, NULL, moving);
      const pktrt__tri_candidates e = pktrt__tri_filter_block(&q, seg, block, index, false, s->lo[n], s->hi[n], moving);
      s->maybe[n] = (uint8_t)e.maybe, s->inside[n] = (uint8_t)e.inside, s->after[n] = (uint8_t)e.after;
      s->ray[n] = (uint8_t)i;
      n += e.maybe != 0;
    }
    s->n = n;
    if (!mask) return hit;
    hit |= pktrt__stream_record(seg, b, list, s, moving);
  }
}

/* Returns the rays of mask that hit anything in a block. WHY without branches: whether a ray crosses any of eight
   triangles is often mispredicted, which costs more than their depths. */
OP uint64_t pktrt__stream_any_block(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                    uint32_t index, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  uint8_t open[64], inside[64], within[64];
  uint64_t hit = 0, unsure = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t i = pktrt__lowest_bit(mask);
    const pktrt__tri_shear q = pktrt__tri_shear_of(b, list[i], NULL, moving);
    const pktrt__tri_occluders o = pktrt__tri_any_block(&q, seg, block, false, moving);
    const uint32_t sure = o.open & o.inside & o.within;
    open[i] = (uint8_t)o.open, inside[i] = (uint8_t)o.inside, within[i] = (uint8_t)o.within;
    hit |= (uint64_t)(sure != 0) << i, unsure |= (uint64_t)(!sure & (o.open != 0)) << i;
  }
  for (; unsure; unsure &= unsure - 1) {
    const uint32_t i = pktrt__lowest_bit(unsure);
    const bool hits = pktrt__tri_settle_any(seg, b, list[i], NULL, index, open[i], inside[i], within[i]);
    hit |= (uint64_t)hits << i;
  }
  return hit;
}

/* Shears a triangle at rest (lane of a block) to the frames of a vector of rays; x and y are both negated, which cancels in
   products. */
OP void pktrt__frustum_shear(const pktrt__frustum *f, const pktrt__batch *b, uint32_t r, const float *k0,
                             const pktrt__frustum_corners *corners, uint32_t lane, vf p[3][3]) {
  const uint32_t axis[3] = {f->ku, f->kv, f->k};
  const vf su = fload(b->slope[0] + r), sv = fload(b->slope[1] + r);
  UNROLL for (int c = 0; c < 3; c++) {
    vf q[3];
    UNROLL for (int j = 0; j < 3; j++) {
      if (f->common) q[j] = fset(corners->p[c][j][lane]);
      else q[j] = fsub(fset(k0[24 * (uint32_t)c + 8 * axis[j] + lane]), fload(b->o[axis[j]] + r));
    }
    p[2][c] = q[2];
    p[0][c] = ffms(su, q[2], q[0]);
    p[1][c] = ffms(sv, q[2], q[1]);
  }
}

/* Returns the rays whose edge functions of a triangle, given its sheared corners, do not rule a hit out. */
OP uint32_t pktrt__frustum_crossed(const vf x[3], const vf y[3], float error) {
  const vf e0 = ffms(x[2], y[1], fmul(y[2], x[1])), e1 = ffms(x[0], y[2], fmul(y[0], x[2]));
  const vf e2 = ffms(x[1], y[0], fmul(y[1], x[0]));
  const vf least = fmin_(e0, fmin_(e1, e2)), most = fmax_(e0, fmax_(e1, e2));
  return ((1u << FW) - 1) & ~fbits(fmand(flt(least, fset(-error)), flt(fset(error), most)));
}

/* Returns the rays of a packet that may hit a triangle at rest. WHY all vectors, also those without rays: a branch costs
   more. */
PKTRT__NOINLINE uint64_t pktrt__frustum_filter_resting(const pktrt__frustum *f, const pktrt__batch *b, const float *k0,
                                                       const pktrt__frustum_corners *corners, uint32_t lane) {
  uint64_t out = 0;
  for (uint32_t i = 0; i < 64; i += FW) {
    vf p[3][3];
    pktrt__frustum_shear(f, b, f->base + i, k0, corners, lane, p);
    out |= (uint64_t)pktrt__frustum_crossed(p[0], p[1], corners->error[lane]) << i;
  }
  return out;
}

/* Tests one triangle at rest (lane of a block) against the rays of mask; returns those that hit it. */
STEP uint64_t pktrt__frustum_test_triangle(const pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b,
                                           const float *k0, const pktrt__frustum_corners *corners, uint32_t lane,
                                           pktrt__tri_common *tri, uint64_t mask) {
  uint64_t result = 0;
  while (mask) {
    const uint32_t i = pktrt__lowest_bit(mask) & ~(FW - 1u), r = f->base + i;
    const uint32_t rays = (uint32_t)(mask >> i) & ((1u << FW) - 1);
    vf p[3][3];
    pktrt__frustum_shear(f, b, r, k0, corners, lane, p);
    result |= (uint64_t)pktrt__frustum_filter(seg, b, r, rays, p[0], p[1], p[2], tri) << i;
    mask &= ~((uint64_t)rays << i);
  }
  return result;
}

/* Tests one moving triangle, its corners at k0 and k1, against a vector of rays with the corners of the canonical test;
   returns those that hit it. */
PKTRT__NOINLINE uint32_t pktrt__frustum_test_moving(const pktrt__frustum *f, const pktrt__bvh_segment *seg,
                                                    pktrt__batch *b, uint32_t r, uint32_t rays, const float *k0,
                                                    const float *k1, pktrt__tri_common *tri) {
  const uint32_t axis[3] = {f->ku, f->kv, f->k};
  const vf tb = fload(b->tb + r), ta = fsub(fset(1), tb), su = fload(b->slope[0] + r), sv = fload(b->slope[1] + r);
  vf x[3], y[3], z[3];
  UNROLL for (int c = 0; c < 3; c++, k0 += 24, k1 += 24) {
    vf q[3];
    UNROLL for (int j = 0; j < 3; j++) {
      const vf p = fadd(fmul(ta, fset(k0[8 * axis[j]])), fmul(tb, fset(k1[8 * axis[j]])));
      q[j] = fsub(p, fload(b->o[axis[j]] + r));
    }
    x[c] = ffms(su, q[2], q[0]), y[c] = ffms(sv, q[2], q[1]), z[c] = q[2];
  }
  return pktrt__frustum_filter(seg, b, r, rays, x, y, z, tri);
}

/* Returns the rays of a packet that may hit a moving triangle (lane of a block), by the filter of >>exactness. x and y
   are both negated, which cancels in products. WHY all vectors, also those without rays: a branch costs more. */
OP uint64_t pktrt__frustum_filter_moving(const pktrt__frustum *f, const pktrt__batch *b,
                                         const pktrt__frustum_motion *motion, uint32_t lane) {
  const uint32_t axis[3] = {f->ku, f->kv, f->k};
  uint64_t out = 0;
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t r = f->base + i;
    const vf su = fload(b->slope[0] + r), sv = fload(b->slope[1] + r), t = fload(b->tb + r);
    vf x[3], y[3];
    UNROLL for (int c = 0; c < 3; c++) {
      vf q[3];
      UNROLL for (int j = 0; j < 3; j++) {
        const vf p = ffma(t, fset(motion->way[c][j][lane]), fset(motion->p[c][j][lane]));
        q[j] = fsub(p, fload(b->o[axis[j]] + r));
      }
      x[c] = ffms(su, q[2], q[0]), y[c] = ffms(sv, q[2], q[1]);
    }
    out |= (uint64_t)pktrt__frustum_crossed(x, y, motion->error[lane]) << i;
  }
  return out;
}
#endif /* PKTRT__OTHER_TESTS */

OP uint32_t pktrt__tri_ray_block_inline(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t index,
                                        const pktrt__variant is) {
  return pktrt__tri_block_template(seg, b, r, NULL, index, is);
}

/* Kernels are templates over three flags known at compile time; these are their instances. One of them counts, for closest
   and any hits (`any`), for what moves and what does not (but for blocks of packets): weights 1 and 0 of one and the same key
   give the same bits. Where there are vectors, scalar kernels need not be fast: there, all always count, paper packets are
   those of vectors, and the fast path has streams, but no frusta, which would be a third of their code. */
#if defined(PKTRT_NO_FRUSTA) || PKTRT__WITH_FEW_INSTANCES
#define FRUSTA 0
#else
#define FRUSTA 1
#endif
#if (!defined(PKTRT_NO_STATS) && PKTRT__WITH_PAPER) || PKTRT__WITH_FEW_INSTANCES
#define IF_COUNTED(x) x
#else
#define IF_COUNTED(x)
#endif
#if !defined(PKTRT_NO_MOTION) && !PKTRT__WITH_FEW_INSTANCES
#define IF_MOVING(x) x
#else
#define IF_MOVING(x)
#endif
#if PKTRT__WITH_FEW_INSTANCES
#define IF_FAST(x)
#define PKTRT__PICK(name) PKTRT__NAME(name##_s)
#else
#define IF_FAST(x) x
#define PKTRT__PICK(name)                                                       \
  (IF_COUNTED(is.stats ? PKTRT__NAME(name##_s) :) is.occlusion                  \
       ? IF_MOVING(is.moving ? PKTRT__NAME(name##_11) :) PKTRT__NAME(name##_10) \
       : IF_MOVING(is.moving ? PKTRT__NAME(name##_01) :) PKTRT__NAME(name##_00))
#endif
#define PKTRT__VARIANTS(INSTANCE)                                             \
  IF_FAST(INSTANCE(00, false, false, false) INSTANCE(10, true, false, false)) \
  IF_MOVING(INSTANCE(01, false, true, false) INSTANCE(11, true, true, false)) \
  IF_COUNTED(INSTANCE(s, any, PKTRT__MOTION != 0, PKTRT__STATS != 0))

#if !PKTRT__WITH_V8_REGISTERS
/* Instances are not inlined: that would make the code a third longer, and no faster. */
#define INSTANCE(tag, o, m, s)                                                                                    \
  PKTRT__NOINLINE uint32_t PKTRT__NAME(pktrt__tri_block_##tag)(const pktrt__bvh_segment *seg, pktrt__batch *b,    \
                                                               uint32_t r, pktrt__single *single, uint32_t index, \
                                                               bool any, pktrt_counts *counts) {                  \
    (void)any;                                                                                                    \
    return pktrt__tri_block_template(seg, b, r, single, index, pktrt__variant_of(o, m, s, counts));               \
  }
PKTRT__VARIANTS(INSTANCE) struct pktrt_scene;
#undef INSTANCE
#endif
OP uint32_t pktrt__tri_ray_block(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t index,
                                 const pktrt__variant is) {
#if !PKTRT__WITH_V8_REGISTERS
  return PKTRT__PICK(pktrt__tri_block)(seg, b, r, NULL, index, is.occlusion, is.counts);
#else
  return pktrt__tri_ray_block_inline(seg, b, r, index, is);
#endif
}
OP bool pktrt__tri_single_block(const pktrt__bvh_segment *seg, pktrt__single *single, uint32_t index,
                                const pktrt__variant is) {
#if !PKTRT__WITH_V8_REGISTERS
  return PKTRT__PICK(pktrt__tri_block)(seg, NULL, 0, single, index, is.occlusion, is.counts) != 0;
#else
  return pktrt__tri_block_template(seg, NULL, 0, single, index, is) != 0;
#endif
}

/* Tests a leaf block at rest against the rays of mask; returns those that hit something in it. WHY all triangles are
   filtered before one is tested, if there is more than one: most rays miss them, and a branch for each vector of rays
   would be mispredicted. */
OP uint64_t pktrt__frustum_leaf(const pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t index,
                                uint64_t mask, const pktrt__variant is) {
  const pktrt__block *block = pktrt__segment_block(seg, index, false);
  const float *k0 = &block->vertex[0][0][0];
  const uint32_t *id = block->id;
  pktrt__frustum_corners corners;
  const uint32_t all = pktrt__lanes_occupied(id);
  uint32_t lanes = pktrt__frustum_cull_triangles(f, k0, &corners) & all;
  COUNT(triangle_culls, pktrt__popcount(all & ~lanes));
  pktrt__tri_common tri;
  tri.counts = is.stats ? is.counts : NULL;
  uint64_t maybe[8] = {UINT64_MAX}, hit = 0;
  if (lanes & (lanes - 1))
    for (uint32_t m = lanes, n = 0; m; m &= m - 1)
      maybe[n++] = pktrt__frustum_filter_resting(f, b, k0, &corners, pktrt__lowest_bit(m));
  for (uint32_t n = 0; lanes && mask; lanes &= lanes - 1, n++) {
    const uint32_t lane = pktrt__lowest_bit(lanes);
    tri.id = id[lane], tri.slot = index * 8 + lane, tri.planar = false;
    tri.range = corners.range[lane], tri.far_ = corners.far_[lane], tri.error = corners.error[lane];
    COUNT(triangle_tests, pktrt__popcount(mask));
    const uint64_t h = pktrt__frustum_test_triangle(f, seg, b, k0, &corners, lane, &tri, mask & maybe[n]);
    hit |= h;
    if (is.occlusion) mask &= ~h;
  }
  return hit;
}

/* Tests a moving leaf block against the rays of mask; returns those that hit something in it. `counts` is NULL where
   nothing is counted. WHY not inlined: less code. */
SMALL uint64_t pktrt__frustum_leaf_moving(const pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b,
                                          uint32_t index, uint64_t mask, bool occlusion, pktrt_counts *counts) {
  const pktrt__block *block = pktrt__segment_block(seg, index, true);
  const float *k0 = pktrt__segment_vertices(seg, block, 0, true), *k1 = pktrt__segment_vertices(seg, block, 1, true);
  const uint32_t *id = block->id;
  pktrt__frustum_motion motion;
  const uint32_t all = pktrt__lanes_occupied(id), lanes = pktrt__frustum_cull_moving(f, k0, k1, &motion) & all;
  if (counts) counts->triangle_culls += pktrt__popcount(all & ~lanes);
  if (counts) counts->triangle_tests += pktrt__popcount(lanes) * pktrt__popcount(mask);
  pktrt__tri_common tri;
  tri.counts = counts;
  uint64_t maybe[8], hit = 0;
  for (uint32_t m = lanes, n = 0; m; m &= m - 1)
    maybe[n++] = pktrt__frustum_filter_moving(f, b, &motion, pktrt__lowest_bit(m));
  for (uint32_t m = lanes, n = 0; m; m &= m - 1, n++) {
    const uint32_t lane = pktrt__lowest_bit(m);
    tri.id = id[lane], tri.slot = index * 8 + lane, tri.planar = false;
    tri.range = motion.range[lane], tri.far_ = motion.far_[lane], tri.error = motion.error[lane];
    for (uint64_t rest = maybe[n] & mask; rest;) {
      const uint32_t i = pktrt__lowest_bit(rest) & ~(FW - 1u);
      const uint32_t rays = (uint32_t)(rest >> i) & ((1u << FW) - 1);
      const uint64_t h = (uint64_t)pktrt__frustum_test_moving(f, seg, b, f->base + i, rays, k0 + lane, k1 + lane, &tri)
                         << i;
      rest &= ~((uint64_t)rays << i);
      hit |= h;
      if (occlusion) mask &= ~h;
    }
  }
  return hit;
}

/* >>single -----------------------------------------------------------------------------------------------------------
   A single ray traverses the tree from a subtree's root. */

/* A single ray as box tests need it, made once per tree. */
typedef struct pktrt__single_slabs {
  v8 rd[3], cn[3], cf[3], wn, ta, tb;
  const pktrt__single *ray;
  size_t near_[3], far_[3]; /* offsets of near and far planes from the first ones of the axis, in floats: 0 or 8 */
} pktrt__single_slabs;

OP pktrt__single_slabs pktrt__single_slabs_of(const pktrt__single *ray, const bool moving) {
  pktrt__single_slabs q;
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    q.rd[a] = vset(ray->rd[a]), q.cn[a] = vset(ray->cn[a]), q.cf[a] = vset(ray->cf[a]);
    q.near_[a] = (ray->octant & 1u << a) << (3 - a), q.far_[a] = 8 ^ q.near_[a];
  }
  q.wn = vset(ray->wn), q.ray = ray;
  if (moving) q.ta = vset(ray->ta), q.tb = vset(ray->tb);
  return q;
}

/* Loads one side of the children along an axis, at the ray's time. */
OP v8 pktrt__single_plane(const pktrt__single_slabs *q, const pktrt__bvh_segment *seg, const pktrt__node *node,
                          const int axis, size_t at, const bool moving) {
  const float *p0 = pktrt__segment_planes(seg, node, 0, moving) + 16 * axis;
  const float *p1 = pktrt__segment_planes(seg, node, 1, moving) + 16 * axis;
  return moving ? vfma(q->ta, vload(p0 + at), vmul(q->tb, vload(p1 + at))) : vload(p0 + at);
}

/* Returns the children of a node that a single ray may hit before the depth wf, and finds its entry depths. */
OP uint32_t pktrt__single_test_children(const pktrt__single_slabs *q, const pktrt__bvh_segment *seg,
                                        const pktrt__node *node, float wf, const bool moving, v8 *entry) {
  v8 n[3], f[3];
  UNROLL for (int a = 0; a < 3; a++) {
    const v8 rd = PKTRT__WITH_FEW_REGISTERS ? vset(q->ray->rd[a]) : q->rd[a];
    const v8 cn = PKTRT__WITH_FEW_REGISTERS ? vset(q->ray->cn[a]) : q->cn[a],
             cf = PKTRT__WITH_FEW_REGISTERS ? vset(q->ray->cf[a]) : q->cf[a];
    n[a] = vfms(pktrt__single_plane(q, seg, node, a, q->near_[a], moving), rd, cn);
    f[a] = vfms(pktrt__single_plane(q, seg, node, a, q->far_[a], moving), rd, cf);
  }
  *entry = vmax(vmax(n[0], n[1]), vmax(n[2], q->wn));
  return mbits(vle(*entry, vmin(vmin(f[0], f[1]), vmin(f[2], vset(wf)))));
}

/* Returns the references of a node's children, and then how many there are: only these are counted as tested. */
OP const uint32_t *pktrt__bvh_children(const pktrt__bvh_segment *seg, uint32_t ref, const bool moving) {
  const pktrt__node *node = pktrt__segment_node(seg, ref, moving);
  return node->child;
}
OP uint32_t pktrt__bvh_child_count(const uint32_t *child) { return 8 - pktrt__popcount8(veq_u32(child, PKTRT__EMPTY)); }

/* Opens a node: returns the children that a single ray may hit before wf, with references and entry depths. */
SHARED uint32_t pktrt__single_open_node(const pktrt__single_slabs *q, const pktrt__bvh_segment *seg, uint32_t ref,
                                        float wf, const uint32_t **child, v8 *entry, const pktrt__variant is) {
  const pktrt__node *node = pktrt__segment_node(seg, ref, is.moving);
  *child = node->child;
  COUNT(node_visits, 1);
  COUNT(box_tests, pktrt__bvh_child_count(*child));
  return pktrt__single_test_children(q, seg, node, wf, is.moving, entry);
}

/* Finds the closest hit of a single ray in a subtree, nearest child first. */
OP bool pktrt__single_closest_hit(const pktrt__bvh_segment *seg, pktrt__single *ray, uint32_t ref,
                                  const pktrt__variant is) {
  struct {
    uint32_t ref;
    float dist;
  } stack[PKTRT__STACK + 8], *top = stack;
  PKTRT__ALIGN64 float dist[8];
  const pktrt__single_slabs q = pktrt__single_slabs_of(ray, is.moving);
  const uint32_t slot = ray->slot, id = ray->id;
  for (;;) {
    if (ref & PKTRT__LEAF) {
      pktrt__tri_single_block(seg, ray, ref & ~PKTRT__LEAF, is);
    } else {
      const uint32_t *child;
      v8 entry;
      uint32_t bits = pktrt__single_open_node(&q, seg, ref, ray->wf, &child, &entry, is);
      if (bits) {
        uint32_t c = pktrt__lowest_bit(bits);
        ref = child[c];
        if (!(bits &= bits - 1)) continue;
        vstore(dist, entry);
        float best = dist[c];
        do { /* the nearest child is next, the others are pushed */
          c = pktrt__lowest_bit(bits);
          const float d = dist[c];
          const uint32_t other = child[c];
          pktrt__bvh_prefetch(seg, other, is.moving);
          if (d < best) {
            top->ref = ref, top->dist = best;
            ref = other, best = d;
          } else {
            top->ref = other, top->dist = d;
          }
          top++;
        } while (bits &= bits - 1);
        continue;
      }
    }
    do {
      if (top == stack) return ray->slot != slot || ray->id != id;
      ref = (--top)->ref;
    } while (top->dist > ray->wf);
  }
}

/* Tells whether a single ray hits anything in a subtree; enters children in the build's order, the last one first. */
OP bool pktrt__single_any_hit(const pktrt__bvh_segment *seg, pktrt__single *ray, uint32_t ref,
                              const pktrt__variant is) {
  uint32_t refs[PKTRT__STACK + 8], *top = refs;
  const pktrt__single_slabs q = pktrt__single_slabs_of(ray, is.moving);
  for (;;) {
    if (ref & PKTRT__LEAF) {
      if (pktrt__tri_single_block(seg, ray, ref & ~PKTRT__LEAF, is)) return true;
    } else {
      const uint32_t *child;
      v8 entry;
      uint32_t bits = pktrt__single_open_node(&q, seg, ref, ray->wf, &child, &entry, is);
      if (bits) {
        ref = child[pktrt__lowest_bit(bits)];
        while (bits &= bits - 1) *top++ = ref, ref = child[pktrt__lowest_bit(bits)];
        continue;
      }
    }
    if (top == refs) return false;
    ref = *--top;
  }
}

/* >>stream ----------------------------------------------------------------------------------------------------------

   Up to 64 rays of one octant traverse a subtree together. Every ray does the work it would do alone; they share node
   loads, the order of the children and the stack, whose entries carry the mask of the rays concerned. Bit i of a mask
   stands for ray list[i]. Functions return the mask of the rays that hit something. */
typedef struct pktrt__stream_stack {
  uint64_t masks[PKTRT__STACK + 8];
  uint32_t refs[PKTRT__STACK + 8], n;
  float dists[PKTRT__STACK + 8]; /* unused for any hit */
} pktrt__stream_stack;

/* Opens a node for the rays of mask and pushes its children, for any hit in the order of the build. */
OP void pktrt__stream_open_node(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                uint32_t ref, uint32_t octant, pktrt__stream_stack *stack, const pktrt__variant is) {
  const pktrt__node *node = pktrt__segment_node(seg, ref, is.moving);
  const uint32_t *child = node->child;
  const pktrt__box_slabs s = pktrt__box_load_slabs(seg, node, octant, is.moving);
  const uint32_t sp = stack->n;
  a8 rays = azero();
  v8 dist = vset(INFINITY);
  for (uint64_t m = mask; m; m &= m - 1) {
    const uint32_t i = pktrt__lowest_bit(m);
    v8 entry;
    const m8 enters = pktrt__box_test_children(&s, b, list[i], is.moving, &entry);
    rays = aor(rays, enters, i);
    if (!is.occlusion) dist = vsel(enters, entry, dist); /* used for children that only one ray enters */
  }
  stack->n += apush(rays, child, dist, is.occlusion ? PKTRT__IN_ORDER : node->order[octant], stack->masks + sp,
                    stack->refs + sp, stack->dists + sp);
  for (uint32_t i = sp; i < stack->n; i++) pktrt__bvh_prefetch(seg, stack->refs[i], is.moving);
}

/* Tests the rays of mask against a block one by one, or for any hit together where that is faster; returns those that
   hit. */
OP uint64_t pktrt__stream_leaf(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                               uint32_t index, const pktrt__variant is) {
  uint64_t hit = 0;
  if (PKTRT__WITH_V8_REGISTERS && is.occlusion && !is.stats)
    return pktrt__stream_any_block(seg, b, list, mask, index, is.moving);
  for (; mask; mask &= mask - 1) {
    const uint32_t i = pktrt__lowest_bit(mask);
    if (pktrt__tri_ray_block(seg, b, list[i], index, is)) hit |= (uint64_t)1 << i;
  }
  return hit;
}

/* Traces a stream through a subtree; returns the rays that hit something. WHY closest hits in a block are recorded after
   the next block's are noted, or before the next node is opened: whether there are any is known late, and need not be
   waited for. */
OP uint64_t pktrt__stream_template(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                   uint32_t ref, const pktrt__variant is) {
  pktrt__stream_stack stack;
  pktrt__stream_notes notes[2];
  uint64_t hit = 0;
  const uint32_t octant = b->octant[list[pktrt__lowest_bit(mask)]];
  const bool noted = PKTRT__WITH_V8_REGISTERS && !is.occlusion && !is.stats;
  uint32_t last = 0; /* whose notes are the last block's */
  stack.n = 0;
  if (noted) notes[0].n = notes[1].n = 0;
  for (;;) {
    if (!(ref & PKTRT__LEAF)) {
      if (noted && notes[last].n) hit |= pktrt__stream_record(seg, b, list, &notes[last], is.moving);
      COUNT(node_visits, 1);
      COUNT(box_tests, pktrt__bvh_child_count(pktrt__bvh_children(seg, ref, is.moving)) * pktrt__popcount(mask));
      pktrt__stream_open_node(seg, b, list, mask, ref, octant, &stack, is);
    } else if (noted) {
      hit |= pktrt__stream_closest_block(seg, b, list, mask, ref & ~PKTRT__LEAF, &notes[1 - last], is.moving);
      hit |= pktrt__stream_record(seg, b, list, &notes[last], is.moving);
      last = 1 - last;
    } else {
      hit |= pktrt__stream_leaf(seg, b, list, mask, ref & ~PKTRT__LEAF, is);
    }
    do { /* masks of entries pushed earlier may hold rays that are done */
      if (!stack.n) return noted ? hit | pktrt__stream_record(seg, b, list, &notes[last], is.moving) : hit;
      mask = stack.masks[--stack.n];
      if (is.occlusion) mask &= ~hit;
      else if (!(mask & (mask - 1)) && stack.dists[stack.n] > b->wf[list[pktrt__lowest_bit(mask)]]) mask = 0;
    } while (!mask);
    ref = stack.refs[stack.n];
  }
}

#define INSTANCE(tag, o, m, s)                                                                                \
  PKTRT__NOINLINE bool PKTRT__NAME(pktrt__single_##tag)(const pktrt__bvh_segment *seg, pktrt__single *ray,    \
                                                        uint32_t ref, bool any, pktrt_counts *counts) {       \
    (void)any;                                                                                                \
    return o ? pktrt__single_any_hit(seg, ray, ref, pktrt__variant_of(o, m, s, counts))                       \
             : pktrt__single_closest_hit(seg, ray, ref, pktrt__variant_of(o, m, s, counts));                  \
  }                                                                                                           \
  PKTRT__NOINLINE uint64_t PKTRT__NAME(pktrt__stream_##tag)(const pktrt__bvh_segment *seg, pktrt__batch *b,   \
                                                            const uint8_t *list, uint64_t mask, uint32_t ref, \
                                                            bool any, pktrt_counts *counts) {                 \
    (void)any;                                                                                                \
    return pktrt__stream_template(seg, b, list, mask, ref, pktrt__variant_of(o, m, s, counts));               \
  }
PKTRT__VARIANTS(INSTANCE) struct pktrt_scene;
#undef INSTANCE

OP bool pktrt__single_traverse(const pktrt__bvh_segment *seg, pktrt__single *ray, uint32_t ref,
                               const pktrt__variant is) {
  return PKTRT__PICK(pktrt__single)(seg, ray, ref, is.occlusion, is.counts);
}
/* Traces the rays of mask through a subtree, one alone as a single ray; returns those that hit something. */
OP uint64_t pktrt__stream_traverse(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                   uint32_t ref, const pktrt__variant is) {
  if (!(mask & (mask - 1))) {
    const uint32_t r = list[pktrt__lowest_bit(mask)];
    pktrt_ray ray;
    pktrt__single q;
    pktrt__single_from_batch(b, r, &ray, &q);
    if (!pktrt__single_traverse(seg, &q, ref, is)) return 0;
    pktrt__single_to_batch(b, r, &q);
    return mask;
  }
  return PKTRT__PICK(pktrt__stream)(seg, b, list, mask, ref, is.occlusion, is.counts);
}

/* >>packets: frustum packets through the tree ---------------------------------------------------------------------- */

typedef struct pktrt__frustum_entry {
  uint64_t mask;
  const float *plane; /* planes of the child at key 0 of the segment; NULL: all rays enter it */
  float w;            /* entry depth */
  uint32_t ref;
} pktrt__frustum_entry;

/* Pushes the children that reach into the frustum, farthest first, for any hit in build order; returns how many. */
OP uint32_t pktrt__frustum_open_node(const pktrt__frustum *f, const pktrt__bvh_segment *seg, uint32_t ref,
                                     uint64_t mask, pktrt__frustum_entry *stack, const pktrt__variant is) {
  const pktrt__node *node = pktrt__segment_node(seg, ref, is.moving);
  const uint32_t *child = node->child;
  const float *p0 = pktrt__segment_planes(seg, node, 0, is.moving),
              *p1 = pktrt__segment_planes(seg, node, 1, is.moving);
  PKTRT__ALIGN64 float w[8];
  v8 entry;
  uint32_t whole;
  const uint32_t keep = is.moving ? pktrt__frustum_cull_children_moving(f, p0, p1, &entry, &whole)
                                  : pktrt__frustum_cull_children(f, p0, p1, false, &entry, &whole);
  const uint32_t n = pktrt__popcount(keep);
  COUNT(node_visits, 1);
  COUNT(frustum_culls, pktrt__bvh_child_count(child) - n);
  vstore(w, entry);
  uint64_t order = vorder_children(keep, is.occlusion ? PKTRT__IN_ORDER : node->order[f->octant]);
  for (uint32_t i = 0; i < n; i++, order >>= 8) {
    const uint32_t c = order & 7;
    stack[i].mask = mask, stack[i].plane = whole >> c & 1 ? NULL : p0 + c, stack[i].w = w[c], stack[i].ref = child[c];
    if (!is.moving && i + 1 < n) pktrt__bvh_prefetch(seg, child[c], false); /* the last one is opened at once */
  }
  return n;
}

/* Tells whether so few rays are left that a stream is faster. Times, as measured, are flat around the numbers
   here, but moving shadow rays lose up to a quarter two steps earlier. */
OP bool pktrt__frustum_is_thin(const pktrt__frustum *f, uint64_t mask, uint32_t ref, const bool occlusion,
                               const bool moving) {
  const uint32_t few = ref & PKTRT__LEAF ? 4 : 8;
  return pktrt__popcount(mask) <= few * ((moving ? 4u : 2u) + occlusion + !f->common);
}

#if FRUSTA
#if PKTRT__WITH_TOP_FRUSTA
SMALL uint64_t pktrt__place_packet(pktrt__frustum *f, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                                   pktrt__batch *b, uint64_t mask, uint32_t ref, bool thin, const pktrt__variant *what);
#endif
/* Traces a frustum packet through one tree from its root; returns the occluded rays. */
OP uint64_t pktrt__frustum_template(pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b, uint64_t mask,
                                    const pktrt_scene *top, const pktrt__variant is) {
  pktrt__frustum_entry stack[PKTRT__STACK + 8];
  const ptrdiff_t to_key1 =
      is.moving ? ((ptrdiff_t)seg->plane1 - (ptrdiff_t)seg->plane0) / (ptrdiff_t)sizeof(float) : 0;
  const bool still = !is.moving || (is.stats && !seg->vertex1); /* at rest, counted: see PKTRT__VARIANTS */
  const uint64_t mask_all = mask;
  uint64_t alive = mask, hit = 0;
  uint32_t sp = 0, ref = 0;
  /* What hid rays of the last packet is asked first. WHY not where counted: counts depend on rays alone. */
  if (is.occlusion && !is.stats && !is.moving && b->occluder_tree == seg->blocks) {
    stack[0].mask = mask, stack[0].plane = NULL, stack[0].w = -INFINITY, stack[0].ref = 0;
    sp = 1, ref = b->occluder, b->occluder_tree = NULL;
  }
  for (;;) {
    const bool thin = pktrt__frustum_is_thin(f, mask, ref, is.occlusion, !still);
    if (thin) COUNT(fallbacks, 1);
    (void)top;
#if PKTRT__WITH_TOP_FRUSTA
    if (top && (thin || ref & PKTRT__LEAF)) {
      hit = pktrt__place_packet(f, top, seg, b, mask, ref, thin, &is);
    } else
#endif
        if (thin) {
      hit = pktrt__stream_traverse(seg, b, f->list, mask, ref, is);
    } else if (ref & PKTRT__LEAF) {
      hit = still ? pktrt__frustum_leaf(f, seg, b, ref & ~PKTRT__LEAF, mask, is)
                  : pktrt__frustum_leaf_moving(f, seg, b, ref & ~PKTRT__LEAF, mask, is.occlusion,
                                               is.stats ? is.counts : NULL);
    } else {
      sp += pktrt__frustum_open_node(f, seg, ref, mask, stack + sp, is);
    }
    if (hit) {
      if (is.occlusion && !is.stats && !is.moving && ref & PKTRT__LEAF && pktrt__popcount(hit) > 16)
        b->occluder_tree = seg->blocks, b->occluder = ref;
      if (is.occlusion && !(alive &= ~hit)) return mask_all;
      pktrt__frustum_update_depth(f, b, alive);
      hit = 0;
    }
    do {
      if (!sp) return mask_all & ~alive;
      const pktrt__frustum_entry *e = &stack[--sp];
      mask = e->w > f->wmax ? 0 : e->mask & alive, ref = e->ref;
      if (mask && e->plane) {
        COUNT(box_tests, pktrt__popcount(mask));
        if (is.moving) mask = pktrt__frustum_test_child_moving(f, b, e->plane, e->plane + to_key1, mask);
        else if (f->common) mask = pktrt__frustum_test_child_from(f, b, e->plane, mask);
        else mask = pktrt__frustum_test_child(f, b, e->plane, e->plane, mask, false);
        COUNT(ray_culls, !mask);
      }
    } while (!mask);
  }
}
#endif

#ifndef PKTRT__NO_TOP
SMALL void pktrt__place_stream(const pktrt__query *call, const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list,
                               uint64_t mask, const pktrt__variant *what);
SMALL bool pktrt__place_single(const pktrt_scene *scene, pktrt__single *q, const pktrt__variant *what);
#if PKTRT__WITH_TOP_FRUSTA
SMALL void pktrt__place_frustum(pktrt__frustum *f, const pktrt_scene *scene, pktrt__batch *b, uint64_t mask,
                                const pktrt__variant *what);
#endif
#if PKTRT__WITH_V8_REGISTERS && !defined(PKTRT_NO_INSTANCES)
PKTRT__NOINLINE void pktrt__place_resolve8(const pktrt_scene *scene, pktrt__batch *b, uint32_t i, uint32_t hits);
#endif
#endif

#if !PKTRT__WITH_PAPER_PATH
#define pktrt__drive_paper PKTRT__BASE(pktrt__drive_paper)
#elif !defined(PKTRT_NO_PAPER)
#define pktrt__drive_paper PKTRT__NAME(pktrt__drive_paper)
/* >>paper ------------------------------------------------------------------------------------------------------------
   The packet traversal of the paper (sections 3.1 and 3.3, after Wald et al. 2007 and Boulos et al. 2006), on the same
   tree: packets of 1 to 256 rays without a common origin. A packet enters a child as soon as one of its rays does;
   false positives cost time but no correctness. For each child:

     1. FIRST ACTIVE RAY. Rays before it are known to miss an ancestor. If it (or a ray of its SIMD group, 3.1) hits the
        child, the whole packet descends for the price of one test.
     2. INTERVAL ARITHMETIC. If it misses, one test asks whether any ray can hit: origins, reciprocal directions and the
        active depth are intervals over the packet, and so are the distances to the child's planes.
     3. FRUSTUM. Where all rays share origin and main axis, four planes through that origin do the same, more tightly.
     4. THE OTHER RAYS, group by group, until one hits: it becomes the first active ray below the child. Then from the
        other end, to find where the active range ends (as Overbeck et al. 2008; the paper has its beginning only).

   At a leaf the groups of the active range are tested against its box first, then those left against its triangles:
   where surfaces scatter the rays of a packet this saves nine of ten triangle tests. Moving packets: boxes are taken at
   each ray's own time in 1 and 4, and over the packet's interval of time in 2 and 3. */

typedef struct pktrt__paper_packet {
  const pktrt__query *call;
  pktrt__batch *b;
  const pktrt__bvh_segment *seg;
  uint32_t base, end; /* rays of the packet */
  uint32_t last;      /* where the active range ends: rays from it on are known to miss an ancestor */
  uint64_t active[PKTRT__BATCH / 64];
  bool one_sign[3], forward[3];                          /* whether all directions agree on an axis, and point up it */
  float o_lo[3], o_hi[3], r_lo[3], r_hi[3], pad, wn, wf; /* intervals: origin, 1/G, depth */
  uint8_t one_axis[PKTRT__BATCH / 8];                    /* whether all rays of a group agree on the main axis */
  bool has_frustum;
  uint32_t axis[3]; /* u, v, k of the frustum */
  float sign, slope_lo[2], slope_hi[2];
  float ta[2], tb[2]; /* the keys' weights at the packet's earliest and latest time */
  uint32_t entering;  /* the rays of the first active ray's group that may hit the child just entered */
  uint32_t steps;     /* bits of pktrt_paper_step */
  uint32_t tree, number, depth, tested; /* as in pktrt_event */
} pktrt__paper_packet;

OP uint32_t pktrt__paper_active(const pktrt__paper_packet *p, uint32_t r) { /* of rays r to r+7, r a multiple of 8 */
  return (uint32_t)(p->active[r / 64] >> r % 64) & 0xFF;
}
PKTRT__COLD void pktrt__paper_tell(pktrt__paper_packet *p, pktrt_event_kind kind, uint32_t index, uint32_t child,
                                   uint32_t ray, uint32_t active) {
  pktrt_event e;
  e.kind = kind, e.index = index, e.child = child, e.ray = ray - p->base, e.active = active;
  e.tested = p->tested, e.tree = p->tree, e.packet = p->number, e.depth = p->depth;
  p->tested = 0;
  p->call->desc->trace(p->call->desc->user, &e);
}
/* Tells of a packet's active range from a ray on. */
OP void pktrt__paper_event(pktrt__paper_packet *p, pktrt_event_kind kind, uint32_t index, uint32_t child, uint32_t ray,
                           const pktrt__variant is) {
  if (is.stats && p->call->desc->trace) pktrt__paper_tell(p, kind, index, child, ray, p->last - ray);
}

/* Computes the intervals over the active rays, and whether they can have a frustum. */
static void pktrt__paper_intervals(pktrt__paper_packet *p) {
  const pktrt__batch *b = p->b;
  float t_lo = 1, t_hi = 0;
  bool first = true, one_axis = true;
  uint8_t main_axis[PKTRT__BATCH / 8];
  p->pad = 0, p->wn = INFINITY, p->wf = -INFINITY;
  memset(main_axis, 3, sizeof main_axis), memset(p->one_axis, true, sizeof p->one_axis);
  for (uint32_t r = p->base; r < p->end; r++) {
    if (!(p->active[r / 64] >> r % 64 & 1)) continue;
    const uint32_t k = b->axis[r];
    const float sign = b->dk[r] < 0 ? -1.0f : 1.0f;
    if (first) p->axis[2] = k, p->axis[0] = (k + 1) % 3, p->axis[1] = (k + 2) % 3, p->sign = sign;
    one_axis = one_axis && k == p->axis[2] && sign == p->sign;
    if (main_axis[r / 8] == 3) main_axis[r / 8] = (uint8_t)k;
    if (main_axis[r / 8] != k) p->one_axis[r / 8] = false;
    for (int a = 0; a < 3; a++) {
      const float o = b->o[a][r], rd = b->rd[a][r];
      p->o_lo[a] = first ? o : pktrt__minf(p->o_lo[a], o), p->o_hi[a] = first ? o : pktrt__maxf(p->o_hi[a], o);
      p->r_lo[a] = first ? rd : pktrt__minf(p->r_lo[a], rd), p->r_hi[a] = first ? rd : pktrt__maxf(p->r_hi[a], rd);
    }
    for (int a = 0; a < 2; a++) {
      const float g = sign * b->slope[a][r];
      p->slope_lo[a] = first ? g : pktrt__minf(p->slope_lo[a], g),
      p->slope_hi[a] = first ? g : pktrt__maxf(p->slope_hi[a], g);
    }
    p->pad = pktrt__maxf(p->pad, b->pad[r]);
    p->wn = pktrt__minf(p->wn, b->wn[r]), p->wf = pktrt__maxf(p->wf, b->wf[r]);
    t_lo = pktrt__minf(t_lo, b->tb[r]), t_hi = pktrt__maxf(t_hi, b->tb[r]);
    first = false;
  }
  p->has_frustum = one_axis && p->wn >= -p->pad && (p->steps & PKTRT_PAPER_STEP_FRUSTUM);
  for (int a = 0; a < 3; a++) {
    p->forward[a] = p->r_lo[a] > 0;
    p->one_sign[a] = p->forward[a] || p->r_hi[a] < 0;
    if (p->o_lo[a] != p->o_hi[a]) p->has_frustum = false;
  }
  p->ta[0] = 1 - t_lo, p->tb[0] = t_lo, p->ta[1] = 1 - t_hi, p->tb[1] = t_hi;
}

/* Computes a child's box over the packet's interval of time; p0 and p1 are its first plane at the segment's keys. */
OP void pktrt__paper_box(const pktrt__paper_packet *p, const float *p0, const float *p1, float lo[3], float hi[3],
                         const bool moving) {
  for (int a = 0; a < 3; a++) {
    const float l0 = p0[16 * a], h0 = p0[16 * a + 8];
    lo[a] = l0, hi[a] = h0;
    if (!moving) continue;
    const float l1 = p1[16 * a], h1 = p1[16 * a + 8];
    lo[a] = pktrt__minf(p->ta[0] * l0 + p->tb[0] * l1, p->ta[1] * l0 + p->tb[1] * l1);
    hi[a] = pktrt__maxf(p->ta[0] * h0 + p->tb[0] * h1, p->ta[1] * h0 + p->tb[1] * h1);
  }
}

/* Tells whether interval arithmetic shows that every ray misses the box (step 2). Along an axis where all rays go up,
   the least distance to the near plane is the least of (lo - o) r over o in [o_lo, o_hi], r in [r_lo, r_hi], etc. */
static bool pktrt__paper_interval_misses(const pktrt__paper_packet *p, const float lo[3], const float hi[3]) {
  float n = p->wn, f = p->wf;
  for (int a = 0; a < 3; a++) {
    if (!p->one_sign[a]) continue;
    const float below = lo[a] - p->o_hi[a] - p->pad, above = hi[a] - p->o_lo[a] + p->pad;
    const float near_ = p->forward[a] ? below : above, far_ = p->forward[a] ? above : below;
    n = pktrt__maxf(pktrt__minf(near_ * p->r_lo[a], near_ * p->r_hi[a]), n);
    f = pktrt__minf(pktrt__maxf(far_ * p->r_lo[a], far_ * p->r_hi[a]), f);
  }
  return n > f;
}

/* Tells whether the box is outside one of the planes u = slope W through the common origin, W in [w0, w1] (step 3). */
static bool pktrt__paper_frustum_misses(const pktrt__paper_packet *p, const float lo[3], const float hi[3]) {
  const uint32_t k = p->axis[2];
  const float o = p->o_lo[k];
  const float w0 = pktrt__maxf((p->sign > 0 ? lo[k] - o : o - hi[k]) - p->pad, 0),
              w1 = (p->sign > 0 ? hi[k] - o : o - lo[k]) + p->pad;
  for (int a = 0; a < 2; a++) {
    const float l = lo[p->axis[a]] - p->o_lo[p->axis[a]] - p->pad, h = hi[p->axis[a]] - p->o_lo[p->axis[a]] + p->pad;
    if (l > pktrt__maxf(p->slope_hi[a] * w0, p->slope_hi[a] * w1)) return true;
    if (h < pktrt__minf(p->slope_lo[a] * w0, p->slope_lo[a] * w1)) return true;
  }
  return w1 < 0;
}

/* A child of a node: its planes, at both keys of the segment if the tree moves. */
typedef struct pktrt__paper_child {
  const float *p0, *p1;
  v8 lo[3], hi[3]; /* the same planes for a static tree, in every lane */
  uint32_t node, index;
} pktrt__paper_child;

OP pktrt__paper_child pktrt__paper_child_of(const float *p0, const float *p1, uint32_t node, uint32_t index) {
  pktrt__paper_child c;
  c.p0 = p0, c.p1 = p1, c.node = node, c.index = index;
  UNROLL for (int a = 0; a < 3; a++) c.lo[a] = vset(p0[16 * a]), c.hi[a] = vset(p0[16 * a + 8]);
  return c;
}

/* Returns those of rays r to r+7 that are active, in `among`, and may hit a child. */
STEP uint32_t pktrt__paper_test_group(pktrt__paper_packet *p, const pktrt__paper_child *c, uint32_t r, uint32_t among,
                                      const pktrt__variant is) {
  const uint32_t active = pktrt__paper_active(p, r) & among;
  if (is.stats) p->tested += pktrt__popcount8(active);
  COUNT(box_tests, pktrt__popcount8(active));
  COUNT(vector_box_tests, 1);
  if (!is.moving) return pktrt__box_test_rays(p->b, r, c->lo, c->hi) & active;
  const v8 tb = vload(p->b->tb + r), ta = vsub(vset(1), tb);
  v8 lo[3], hi[3];
  UNROLL for (int a = 0; a < 3; a++) {
    lo[a] = vfma(ta, c->lo[a], vmul(tb, vset(c->p1[16 * a])));
    hi[a] = vfma(ta, c->hi[a], vmul(tb, vset(c->p1[16 * a + 8])));
  }
  return pktrt__box_test_rays(p->b, r, lo, hi) & active;
}

/* Ends the active range behind the last group with a ray that may hit a child, and not before `ray`'s. */
OP void pktrt__paper_trim(pktrt__paper_packet *p, const pktrt__paper_child *c, uint32_t ray, const pktrt__variant is) {
  const uint32_t last = p->last;
  for (uint32_t i = (last - 1) & ~7u; i > ray; p->last = i, i -= 8)
    if (pktrt__paper_active(p, i) && pktrt__paper_test_group(p, c, i, ~0u, is)) break;
  if (p->last < last) pktrt__paper_event(p, PKTRT_EVENT_TRIM, c->node, c->index, ray, is);
}

/* Finds the first ray from `first` on that may hit a child (steps 1 to 4), or returns p->end. */
PKTRT__NOINLINE uint32_t pktrt__paper_find_first(pktrt__paper_packet *p, const pktrt__paper_child *c, uint32_t first,
                                                 const pktrt__variant is) {
  const uint32_t from = ~0u << first % 8, with = p->steps & PKTRT_PAPER_STEP_GROUP ? from : from & ~(from << 1);
  uint32_t r = first & ~7u, among = from & ~with; /* of group r: rays that are still to be tested */
  p->entering = pktrt__paper_test_group(p, c, r, with, is);
  if (!p->entering) {
    float lo[3], hi[3];
    pktrt__paper_box(p, c->p0, c->p1, lo, hi, is.moving);
    if ((p->steps & PKTRT_PAPER_STEP_INTERVALS) && pktrt__paper_interval_misses(p, lo, hi)) {
      COUNT(interval_culls, 1);
      pktrt__paper_event(p, PKTRT_EVENT_INTERVAL_CULL, c->node, c->index, first, is);
      return p->end;
    }
    if (p->has_frustum && pktrt__paper_frustum_misses(p, lo, hi)) {
      COUNT(frustum_culls, 1);
      pktrt__paper_event(p, PKTRT_EVENT_FRUSTUM_CULL, c->node, c->index, first, is);
      return p->end;
    }
    for (; r < p->last; r += 8, among = ~0u)
      if ((pktrt__paper_active(p, r) & among) && (p->entering = pktrt__paper_test_group(p, c, r, among, is)) != 0)
        break;
    if (!p->entering) {
      COUNT(ray_culls, 1);
      pktrt__paper_event(p, PKTRT_EVENT_ALL_MISS, c->node, c->index, first, is);
      return p->end;
    }
    if (p->steps & PKTRT_PAPER_STEP_TRIM) pktrt__paper_trim(p, c, r + pktrt__lowest_bit(p->entering), is);
  }
  const uint32_t ray = r + pktrt__lowest_bit(p->entering);
  COUNT(first_hits, ray == first);
  COUNT(later_hits, ray != first);
  pktrt__paper_event(p, ray == first ? PKTRT_EVENT_FIRST_HIT : PKTRT_EVENT_LATER_HIT, c->node, c->index, ray, is);
  return ray;
}

/* Returns one coordinate of one corner of a triangle, at the times of eight rays. */
OP v8 pktrt__tri_corner_of_one(const float *k0, const float *k1, v8 ta, v8 tb, const bool moving) {
  return moving ? vadd(vmul(ta, vset(*k0)), vmul(tb, vset(*k1))) : vset(*k0);
}

/* Tests one triangle, given its edge functions, against those of rays r to r+7 in bits; returns those that take it. */
PKTRT__NOINLINE uint32_t pktrt__paper_accept8(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t bits,
                                              const pktrt__tri_edges *edges, const v8 *z, pktrt__tri_common *tri) {
  pktrt__tri_limits l;
  l.sign = vcopysign(vset(1), vload(b->dk + r)), l.tiny = vload(b->tiny + r);
  l.wn = vload(b->wn + r), l.wf = vload(b->wf + r), l.sn = vload(b->sn + r);
  const pktrt__tri_estimate e = pktrt__tri_depth_bounds(edges, z, &l);
  bits &= e.maybe;
  uint32_t taken = bits & e.inside & e.after & mbits(vlt(e.hi, vload(b->sf + r))), open = bits & ~taken;
  if (tri->counts)
    tri->counts->canonical_tests += pktrt__popcount(bits), tri->counts->settlings += pktrt__popcount(open);
  pktrt__frustum_set_hits(seg, b, r, taken, fwide(e.lo), fwide(e.hi), tri->id, tri->slot);
  for (; PKTRT__UNLIKELY(open); open &= open - 1)
    if (pktrt__exact_test(seg, b, r + pktrt__lowest_bit(open), tri->id, tri->slot)) taken |= open & (0u - open);
  return taken;
}

/* Tests one triangle against the rays `bits` of r to r+7, which share a main axis. Returns those that hit it. */
PKTRT__NOINLINE uint32_t pktrt__paper_test_triangle(const pktrt__paper_packet *p, const float *k0, const float *k1,
                                                    uint32_t r, uint32_t bits, uint32_t id, uint32_t slot,
                                                    const pktrt__variant is) {
  pktrt__batch *b = p->b;
  const uint32_t k = b->axis[r + pktrt__lowest_bit(bits)], ku = (k + 1) % 3, kv = (k + 2) % 3;
  const v8 ok = vload(b->o[k] + r), ou = vload(b->o[ku] + r), ov = vload(b->o[kv] + r);
  const v8 su = vload(b->slope[0] + r), sv = vload(b->slope[1] + r);
  const v8 tb = is.moving ? vload(b->tb + r) : ok, ta = is.moving ? vsub(vset(1), tb) : ok;
  v8 x[3], y[3], z[3];
  UNROLL for (uint32_t c = 0; c < 3; c++, k0 += 24, k1 += 24) {
    z[c] = vsub(pktrt__tri_corner_of_one(k0 + 8 * k, k1 + 8 * k, ta, tb, is.moving), ok);
    x[c] = vfms(su, z[c], vsub(pktrt__tri_corner_of_one(k0 + 8 * ku, k1 + 8 * ku, ta, tb, is.moving), ou));
    y[c] = vfms(sv, z[c], vsub(pktrt__tri_corner_of_one(k0 + 8 * kv, k1 + 8 * kv, ta, tb, is.moving), ov));
  }
  COUNT(triangle_tests, pktrt__popcount8(bits));
  COUNT(vector_triangle_tests, 1);
  const pktrt__tri_edges e = pktrt__tri_edge_functions(x, y, z);
  bits &= ~pktrt__tri_outside(&e);
  if (!bits) return 0;
  pktrt__tri_common tri;
  tri.id = id, tri.slot = slot, tri.planar = false, tri.range = tri.far_ = tri.error = 0,
  tri.counts = is.stats ? is.counts : NULL;
  return pktrt__paper_accept8(p->seg, b, r, bits, &e, z, &tri);
}

/* Tests a leaf, child c, against the rays of the active range that may hit its box; those of the first group are
   known. A group whose rays disagree on the main axis is tested ray by ray. Tells whether any ray hit. */
OP bool pktrt__paper_leaf(pktrt__paper_packet *p, const pktrt__paper_child *c, uint32_t index, uint32_t first,
                          const pktrt__variant is) {
  const pktrt__block *block = pktrt__segment_block(p->seg, index, true);
  const float *k0 = pktrt__segment_vertices(p->seg, block, 0, true);
  const float *k1 = pktrt__segment_vertices(p->seg, block, 1, true);
  const uint32_t *id = block->id;
  bool any = false, known = p->steps & PKTRT_PAPER_STEP_GROUP; /* which of the first group hit the box */
  pktrt__paper_event(p, PKTRT_EVENT_LEAF, index, 0, first, is);
  for (uint32_t r = first & ~7u, among = ~0u << first % 8; r < p->last; r += 8, among = ~0u, known = false) {
    uint32_t bits = pktrt__paper_active(p, r) & among, hits = 0;
    if (!bits) continue;
    if (p->steps & PKTRT_PAPER_STEP_LEAF_BOXES)
      bits = known ? p->entering : pktrt__paper_test_group(p, c, r, among, is);
    if (is.stats && p->call->desc->trace)
      pktrt__paper_tell(p, PKTRT_EVENT_LEAF_TEST, index, 0, r > first ? r : first, pktrt__popcount8(bits));
    const bool same = p->one_axis[r / 8];
    for (uint32_t m = same ? pktrt__lanes_occupied(id) : 0; m && bits; m &= m - 1) {
      const uint32_t lane = pktrt__lowest_bit(m);
      const uint32_t h = pktrt__paper_test_triangle(p, k0 + lane, k1 + lane, r, bits, id[lane], index * 8 + lane, is);
      for (uint32_t e = h; e; e &= e - 1)
        pktrt__paper_event(p, PKTRT_EVENT_HIT, index, lane, r + pktrt__lowest_bit(e), is);
      hits |= h;
      if (is.occlusion) bits &= ~h;
    }
    for (uint32_t m = same ? 0 : bits; m; m &= m - 1) {
      const uint32_t ray = r + pktrt__lowest_bit(m);
      COUNT(vector_triangle_tests, 1);
      const uint32_t lanes = pktrt__tri_ray_block(p->seg, p->b, ray, index, is);
      for (uint32_t l = lanes; l; l &= l - 1)
        pktrt__paper_event(p, PKTRT_EVENT_HIT, index, pktrt__lowest_bit(l), ray, is);
      if (lanes) hits |= 1u << (ray - r);
    }
    any |= hits != 0;
    if (is.occlusion) p->active[r / 64] &= ~((uint64_t)hits << r % 64);
  }
  return any;
}

/* Updates the depth interval's far end: how far the active rays still reach. */
OP void pktrt__paper_update_depth(pktrt__paper_packet *p) {
  v8 far_ = vset(-INFINITY);
  for (uint32_t r = p->base & ~7u; r < p->end; r += 8)
    far_ = vmax(vsel(mfrom(pktrt__paper_active(p, r)), vload(p->b->wf + r), far_), far_);
  p->wf = vhmax(far_);
}

/* Traces one packet through one tree. In occlusion queries, occluded rays leave p->active. */
OP void pktrt__paper_traverse(pktrt__paper_packet *p, const pktrt__variant is) {
  struct {
    const float *plane; /* of the child, at key 0 of the segment */
    uint32_t ref, first, last, node, child, depth;
  } stack[PKTRT__STACK + 8];
  const pktrt__bvh_segment *seg = p->seg;
  const ptrdiff_t to_key1 =
      is.moving ? ((ptrdiff_t)seg->plane1 - (ptrdiff_t)seg->plane0) / (ptrdiff_t)sizeof(float) : 0;
  uint32_t sp = 0, ref = 0, first = p->base;
  p->depth = p->tested = 0;
  while (first < p->end && !(p->active[first / 64] >> first % 64 & 1)) first++;
  if (first == p->end) return;
  pktrt__paper_intervals(p);
  p->last = p->end;
  pktrt__paper_child c =
      pktrt__paper_child_of(&pktrt__segment_node(seg, 0, true)->plane[0][0], NULL, 0, 0); /* set below */
  for (;;) {
    if (ref & PKTRT__LEAF) {
      if (pktrt__paper_leaf(p, &c, ref & ~PKTRT__LEAF, first, is)) pktrt__paper_update_depth(p);
    } else { /* push a node's children, the first one in the direction of the first active ray on top */
      const pktrt__node *node = pktrt__segment_node(seg, ref, true);
      const uint32_t *child = node->child;
      uint32_t perm = p->steps & PKTRT_PAPER_STEP_ORDER ? node->order[p->b->octant[first]] : 076543210;
      COUNT(node_visits, 1);
      pktrt__paper_event(p, PKTRT_EVENT_NODE, ref, 0, first, is);
      for (int i = 0; i < 8; i++, perm >>= 3) {
        const uint32_t k = perm & 7;
        if (child[k] == PKTRT__EMPTY) continue;
        stack[sp].plane = pktrt__segment_planes(seg, node, 0, true) + k;
        stack[sp].ref = child[k], stack[sp].first = first, stack[sp].last = p->last;
        stack[sp].depth = p->depth + 1, stack[sp].node = ref, stack[sp++].child = k;
      }
    }
    do {
      if (!sp) return;
      first = stack[--sp].first, p->last = stack[sp].last, p->depth = stack[sp].depth;
      while (first < p->last && !(p->active[first / 64] >> first % 64 & 1)) first++; /* occluded by now */
      if (first >= p->last) {
        pktrt__paper_event(p, PKTRT_EVENT_NONE_LEFT, stack[sp].node, stack[sp].child, stack[sp].first, is);
        first = p->end;
      } else {
        const float *plane = stack[sp].plane;
        c = pktrt__paper_child_of(plane, plane + to_key1, stack[sp].node, stack[sp].child);
        first = pktrt__paper_find_first(p, &c, first, is);
      }
    } while (first == p->end);
    ref = stack[sp].ref;
  }
}

/* The only variant of pktrt__paper_traverse: it always counts, and where there is motion serves what is at rest, too. */
PKTRT__COLD void pktrt__paper_traverse_any(pktrt__paper_packet *p, bool occlusion, pktrt_counts *counts) {
  pktrt__paper_traverse(p, pktrt__variant_of(occlusion, PKTRT__MOTION, PKTRT__STATS != 0, counts));
}

/* Traces rays [begin, end) of a batch in packets of desc->packet_size, each through all trees of a scene, or of a model,
   and all segments of those that move. */
PKTRT__NOINLINE void pktrt__drive_paper(const pktrt__query *call, const pktrt_scene *scene, pktrt__batch *b,
                                        uint32_t begin, uint32_t end, const bool occlusion) {
  pktrt_counts unwanted, *counts = call->counts ? call->counts : &unwanted;
  const pktrt__variant is = pktrt__variant_of(occlusion, false, PKTRT__STATS != 0, counts);
  memset(&unwanted, 0, sizeof unwanted);
  pktrt__paper_packet p;
  p.call = call, p.b = b, p.steps = call->desc->paper_steps;
  const uint32_t tree = PKTRT__STATS && call->desc->trace ? pktrt__tree_first(call->scene, scene) : 0;
  for (uint32_t i = 0; i < scene->direct_count; i++) {
    const pktrt__bvh *bvh = &scene->bvhs[i];
    const bool moving = pktrt__has_motion(bvh->key_count);
    p.tree = tree + i;
    if (!(bvh->mask & call->desc->mask)) continue;
    pktrt__batch_time_weights(b, begin, end - begin, bvh->key_count);
    for (p.base = begin; p.base < end; p.base = p.end) {
      p.end = end - p.base < call->desc->packet_size ? end : p.base + call->desc->packet_size;
      p.number = scene == call->scene ? (uint32_t)((call->first + p.base) / call->desc->packet_size) : PKTRT_NONE;
      if (!i) COUNT(packets, 1);
      for (uint32_t segment = 0; segment + 1 < bvh->key_count || !segment; segment++) {
        memset(p.active, 0, sizeof p.active);
        for (uint32_t r = p.base; r < p.end; r++)
          if ((b->valid[r / 64] >> r % 64 & 1) && (!PKTRT__MOTION || bvh->key_count < 3 || b->segment[r] == segment) &&
              (!occlusion || b->slot[r]))
            p.active[r / 64] |= (uint64_t)1 << r % 64;
        uint64_t before[PKTRT__BATCH / 64];
        memcpy(before, p.active, sizeof before);
        pktrt__bvh_segment seg = pktrt__bvh_segment_of(scene->bvhs, i, moving ? segment : 0);
        p.seg = &seg;
        pktrt__paper_traverse_any(&p, occlusion, counts);
        for (uint32_t r = p.base; occlusion && r < p.end; r++)
          if ((before[r / 64] & ~p.active[r / 64]) >> r % 64 & 1) b->slot[r] = 0;
      }
    }
  }
}

#endif /* PKTRT__PAPER */

#if FRUSTA
#define INSTANCE(tag, o, m, s)                                                                                  \
  PKTRT__NOINLINE uint64_t PKTRT__NAME(pktrt__frustum_##tag)(pktrt__frustum * f, const pktrt__bvh_segment *seg, \
                                                             pktrt__batch *b, uint64_t mask, bool any,          \
                                                             pktrt_counts *counts) {                            \
    (void)any;                                                                                                  \
    return pktrt__frustum_template(f, seg, b, mask, NULL, pktrt__variant_of(o, m, s, counts));                  \
  }
PKTRT__VARIANTS(INSTANCE) struct pktrt_scene;
#undef INSTANCE

OP uint64_t pktrt__frustum_traverse(pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b, uint64_t mask,
                                    const pktrt__variant is) {
  return PKTRT__PICK(pktrt__frustum)(f, seg, b, mask, is.occlusion, is.counts);
}
#endif

/* >>drive -----------------------------------------------------------------------------------------------------------

   Splits a batch of rays into packets, streams and single rays, and traces them tree by tree, and through moving trees
   segment by segment, so that a kernel sees one static tree or one linear motion. */

OP uint64_t pktrt__drive_rays_of_segment(const pktrt__batch *b, const uint8_t *list, uint64_t mask, uint32_t segment) {
  uint64_t same = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t i = pktrt__lowest_bit(mask);
    if (b->segment[list[i]] == segment) same |= (uint64_t)1 << i;
  }
  return same;
}

/* Tells whether a ray may meet a tree at any time. WHY: most rays miss what moves, so this test of a moving tree comes
   before all work for the ray's own time. `step` is the distance from one axis to the next in rd, cn and cf. */
OP bool pktrt__drive_may_meet(const pktrt__bvh *bvh, const float *rd, const float *cn, const float *cf, size_t step,
                              float wn, float wf) {
  float n = wn, f = wf;
  UNROLL for (int a = 0; a < 3; a++, rd += step, cn += step, cf += step) {
    const float l = bvh->lo[a] * *rd, h = bvh->hi[a] * *rd;
    n = pktrt__maxf(pktrt__minf(l, h) - *cn, n), f = pktrt__minf(pktrt__maxf(l, h) - *cf, f);
  }
  return n <= f;
}

OP uint64_t pktrt__drive_rays_near(const pktrt__bvh *bvh, const pktrt__batch *b, const uint8_t *list, uint64_t mask) {
  uint64_t near_ = 0, any = 0;
  for (uint32_t w = 0; w < PKTRT__BATCH / 64; w++) any |= b->moving[w];
  for (mask = any ? mask : 0; mask; mask &= mask - 1) {
    const uint32_t i = pktrt__lowest_bit(mask), r = list[i];
    if (!(b->moving[r / 64] >> r % 64 & 1)) continue;
    const bool may = pktrt__drive_may_meet(bvh, &b->rd[0][r], &b->as.slab.cn[0][r], &b->as.slab.cf[0][r], PKTRT__ROW,
                                           b->wn[r], b->wf[r]);
    near_ |= (uint64_t)may << i;
  }
  return near_;
}

/* Traces a stream, rays of one octant, through a tree; returns those that hit, or hit nearer. */
PKTRT__NOINLINE uint64_t pktrt__drive_stream_in(const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list,
                                                uint64_t mask, uint32_t tree, const pktrt__variant *what) {
  const pktrt__variant is = *what;
  const pktrt__bvh *bvh = &scene->bvhs[tree];
  uint64_t hit = 0;
  if (!(bvh->mask & is.mask)) return 0;
  if (!pktrt__has_motion(bvh->key_count)) {
    for (uint64_t m = COUNTED(is) ? mask : 0; m; m &= m - 1)
      pktrt__batch_time_weights(b, list[pktrt__lowest_bit(m)], 1, 1);
    return pktrt__stream_traverse(&bvh->rest, b, list, mask, 0, pktrt__variant_moving(is, false));
  }
  if (tree < scene->direct_count) mask = pktrt__drive_rays_near(bvh, b, list, mask); /* else they meet its box */
  for (uint64_t m = mask; m; m &= m - 1) pktrt__batch_time_weights(b, list[pktrt__lowest_bit(m)], 1, bvh->key_count);
  while (mask) {
    const uint32_t segment = b->segment[list[pktrt__lowest_bit(mask)]];
    const uint64_t same = bvh->key_count > 2 ? pktrt__drive_rays_of_segment(b, list, mask, segment) : mask;
    pktrt__bvh_segment seg = pktrt__bvh_segment_of(scene->bvhs, tree, segment);
    hit |= pktrt__stream_traverse(&seg, b, list, same, 0, pktrt__variant_moving(is, true));
    mask &= ~same;
  }
  return hit;
}
/* Traces a stream through all trees. */
PKTRT__NOINLINE void pktrt__drive_stream(const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                         const pktrt__variant *what) {
  const pktrt__variant is = *what;
  for (uint32_t i = 0; i < scene->direct_count && mask; i++) {
    const uint64_t hit = pktrt__drive_stream_in(scene, b, list, mask, i, &is);
    if (!is.occlusion) continue;
    for (uint64_t m = hit; m; m &= m - 1) b->slot[list[pktrt__lowest_bit(m)]] = 0;
    mask &= ~hit;
  }
#ifndef PKTRT__NO_TOP
  if (scene->has_top && mask) pktrt__place_stream(NULL, scene, b, list, mask, &is);
#endif
}

#if FRUSTA
/* Marks rays of a packet as occluded. */
OP void pktrt__drive_mark(pktrt__batch *b, uint32_t base, uint64_t hit) {
  for (uint32_t r = 0; r < 64; r += FW)
    fstore_masked_u32(b->slot + base + r, ffrom((uint32_t)(hit >> r) & ((1u << FW) - 1)), 0);
}
/* Traces a packet of rays of one main axis and octant through all trees. */
PKTRT__NOINLINE void pktrt__drive_frustum(const pktrt_scene *scene, pktrt__batch *b, uint32_t base, uint64_t mask,
                                          const pktrt__variant *what) {
  const pktrt__variant is = *what;
  pktrt__frustum f;
  pktrt__frustum_setup(&f, scene, b, base, mask, is.occlusion);
  COUNT(packets, 1);
  uint64_t asked = mask; /* the rays whose depth the frustum has */
  for (uint32_t i = 0; i < scene->direct_count && mask; i++) {
    const pktrt__bvh *bvh = &scene->bvhs[i];
    const bool moving = pktrt__has_motion(bvh->key_count);
    uint64_t hit = 0, rest = bvh->mask & is.mask ? mask : 0;
    if (moving && rest) rest = pktrt__box_test_packet(b, base, mask, bvh->lo, bvh->hi);
    if (!rest) continue;
    if (!moving) {
      if (rest != asked || (i > 0 && !is.occlusion)) pktrt__frustum_update_depth(&f, b, asked = rest);
      if (is.stats) pktrt__batch_time_weights(b, base, 64, 1), pktrt__frustum_times(&f, b, rest);
      hit = pktrt__frustum_traverse(&f, &bvh->rest, b, rest, pktrt__variant_moving(is, false));
    } else {
      pktrt__batch_packet_time_weights(b, base, bvh->key_count);
      while (rest) {
        const uint32_t segment = bvh->key_count > 2 ? b->segment[base + pktrt__lowest_bit(rest)] : 0;
        const uint64_t same = bvh->key_count > 2 ? pktrt__drive_rays_of_segment(b, f.list, rest, segment) : rest;
        pktrt__bvh_segment seg = pktrt__bvh_segment_of(scene->bvhs, i, segment);
        pktrt__frustum_times(&f, b, same);
        pktrt__frustum_update_depth(&f, b, asked = same);
        hit |= pktrt__frustum_traverse(&f, &seg, b, same, pktrt__variant_moving(is, true));
        rest &= ~same;
      }
    }
    if (is.occlusion) pktrt__drive_mark(b, base, hit), mask &= ~hit;
  }
#if PKTRT__WITH_TOP_FRUSTA
  if (scene->has_top && mask) pktrt__place_frustum(&f, scene, b, mask, &is);
#elif !defined(PKTRT__NO_TOP)
  if (scene->has_top && mask) pktrt__place_stream(NULL, scene, b, f.list, mask, &is);
#endif
}
#endif

/* Traces one ray through a tree, and tells whether it hits, or hits nearer. */
OP bool pktrt__drive_single_in(const pktrt_scene *scene, pktrt__single *ray, uint32_t tree, const pktrt__variant is) {
  const pktrt__bvh *bvh = &scene->bvhs[tree];
  if (!(bvh->mask & is.mask)) return false;
  if (!pktrt__has_motion(bvh->key_count)) {
    if (COUNTED(is)) ray->ta = 1, ray->tb = 0; /* the only key has all the weight */
    return pktrt__single_traverse(&bvh->rest, ray, 0, pktrt__variant_moving(is, false));
  }
  if (!pktrt__drive_may_meet(bvh, ray->rd, ray->cn, ray->cf, 1, ray->wn, ray->wf)) return false;
  const uint32_t segment = pktrt__time_segment(ray->ray->time, bvh->key_count, &ray->ta, &ray->tb);
  pktrt__bvh_segment seg = pktrt__bvh_segment_of(scene->bvhs, tree, segment);
  return pktrt__single_traverse(&seg, ray, 0, pktrt__variant_moving(is, true));
}
/* Traces one ray through all trees and tells whether it hits. */
PKTRT__NOINLINE bool pktrt__drive_single(const pktrt_scene *scene, pktrt__single *ray, const pktrt__variant *what) {
  const pktrt__variant is = *what;
  bool hit = false;
  for (uint32_t i = 0; i < scene->direct_count && !(is.occlusion && hit); i++)
    hit |= pktrt__drive_single_in(scene, ray, i, is);
#ifndef PKTRT__NO_TOP
  if (scene->has_top && !(is.occlusion && hit)) hit |= pktrt__place_single(scene, ray, &is);
#endif
  return hit;
}
PKTRT__NOINLINE void pktrt__drive_batch_ray(const pktrt_scene *scene, pktrt__batch *b, uint32_t r,
                                            const pktrt__variant *what) {
  const pktrt__variant is = *what;
  pktrt_ray ray;
  pktrt__single q;
  pktrt__single_from_batch(b, r, &ray, &q);
  if (!pktrt__drive_single(scene, &q, &is)) return;
  pktrt__single_to_batch(b, r, &q);
  if (is.occlusion) b->slot[r] = 0;
}

/* Finds which of the rays may meet a moving tree, and sets b->moving. */
OP void pktrt__drive_find_moving(const pktrt_scene *scene, pktrt__batch *b, const uint64_t *rays) {
  memset(b->moving, 0, sizeof b->moving);
  for (uint32_t i = 0; i < scene->direct_count; i++) {
    const pktrt__bvh *bvh = &scene->bvhs[i];
    for (uint32_t w = 0; w < PKTRT__BATCH / 64 && pktrt__has_motion(bvh->key_count); w++)
      if (rays[w]) b->moving[w] |= pktrt__box_test_packet(b, 64 * w, rays[w], bvh->lo, bvh->hi);
  }
}

/* Sorts rays of a batch by octant and traces them in streams of at most 64. */
PKTRT__NOINLINE void pktrt__drive_octants(const pktrt_scene *scene, pktrt__batch *b, const uint64_t *rays,
                                          const pktrt__variant *what) {
  const pktrt__variant is = *what;
  uint8_t list[PKTRT__BATCH];
  pktrt__drive_find_moving(scene, b, rays);
  for (uint8_t o = 0; o < 8; o++) {
    uint32_t end = 0;
    for (uint32_t w = 0; w < PKTRT__BATCH / 64; w++)
      for (uint64_t m = rays[w] ? rays[w] & veq_u8x64(b->octant + 64 * w, o) : 0; m; m &= m - 1)
        list[end++] = (uint8_t)(64 * w + pktrt__lowest_bit(m));
    for (uint32_t i = 0; i < end;) {
      const uint32_t n = end - i < 64 ? end - i : 64, to = i + n;
      COUNT(packets, n < 4 ? n : 1);
      if (n >= 4) pktrt__drive_stream(scene, b, list + i, ~(uint64_t)0 >> (64 - n), &is);
      else /* too few to gain from sharing: measured slower as a stream */
        for (uint32_t k = i; k < to; k++) pktrt__drive_batch_ray(scene, b, list[k], &is);
      i = to;
    }
  }
}

/* Returns the rays of [base, base + 64) with the main axis and octant of ray r. */
OP uint64_t pktrt__drive_rays_along(const pktrt__batch *b, uint32_t base, uint32_t r) {
  return veq_u8x64(b->axis + base, b->axis[r]) & veq_u8x64(b->octant + base, b->octant[r]);
}

/* Returns those of pktrt__drive_rays_along with nearly ray r's slopes and tmin >= 0, as frusta start at origins. */
OP uint64_t pktrt__drive_rays_alike(const pktrt__batch *b, uint32_t base, uint32_t r) {
  const vf su = fset(b->slope[0][r]), sv = fset(b->slope[1][r]), most = fset(0.3f);
  uint64_t near_ = 0;
  for (uint32_t i = base; i < base + 64; i += FW) {
    const vf u = fabs_(fsub(fload(b->slope[0] + i), su)), v = fabs_(fsub(fload(b->slope[1] + i), sv));
    near_ |= (uint64_t)fbits(fmand(flt(fmax_(u, v), most), fle(fset(0), fload(b->tmin + i)))) << (i - base);
  }
  return near_ & pktrt__drive_rays_along(b, base, r);
}

/* Tells whether the rays in mask, of [base, base + 64), are many and go along one axis, as those of a packet should.
   A slack of 0.7 was measured as good as 0.2. */
PKTRT__NOINLINE bool pktrt__drive_is_coherent(const pktrt__batch *b, uint32_t base, uint64_t mask) {
  const uint32_t first = base + pktrt__lowest_bit(mask), k = b->axis[first], ku = (k + 1) % 3, kv = (k + 2) % 3;
  const float sign = b->dk[first] < 0 ? -1.0f : 1.0f;
  if (pktrt__popcount(mask) <= 16) return false;
  for (uint32_t i = 0; i < 64; i += 8) {
    const uint32_t r = base + i, rays = (uint32_t)(mask >> i) & 0xFF;
    const v8 side = vmul(vmax(vabs(vload(b->d[ku] + r)), vabs(vload(b->d[kv] + r))), vset(0.7f));
    const m8 agree = vlt(side, vmul(vload(b->d[k] + r), vset(sign))), forward = vle(vset(0), vload(b->tmin + r));
    if (rays & ~mbits(mand(agree, forward))) return false;
  }
  return true;
}

/* Removes the next frustum packet from *rest, of [base, base + 64), and returns it, or 0. If all go one way, its rays
   share main axis and octant. Else they have similar directions, as after a mirror. WHY so few tries: where the first
   rays have no company, others have none either. */
PKTRT__NOINLINE uint64_t pktrt__drive_next_packet(const pktrt__batch *b, uint32_t base, uint64_t *rest, bool one_way) {
  const uint32_t many = PKTRT__FEW_OF_PACKET;
  uint64_t packet = 0, among = *rest;
  if (one_way) {
    packet = among ? among & pktrt__drive_rays_along(b, base, base + pktrt__lowest_bit(among)) : 0;
  } else {
    for (uint32_t i = 0; i < 3 && pktrt__popcount(among) > many && !packet; i++) {
      const uint32_t first = pktrt__lowest_bit(among);
      const uint64_t alike = among & pktrt__drive_rays_alike(b, base, base + first);
      if (pktrt__popcount(alike) > many) packet = alike;
      among &= ~(alike | (uint64_t)1 << first);
    }
  }
  *rest &= ~packet;
  return packet;
}

/* Traces rays [begin, end) of a batch on the fast path: as frusta, packets within 64 neighbours; the rest as streams by
   octant. */
PKTRT__NOINLINE void pktrt__drive_fast(const pktrt_scene *scene, pktrt__batch *b, uint32_t begin, uint32_t end,
                                       const pktrt__variant *what) {
  const pktrt__variant is = *what;
  uint64_t left[PKTRT__BATCH / 64]; /* rays that no frustum takes */
  memset(left, 0, sizeof left);
  for (uint32_t base = begin; base < end; base += 64) {
    uint64_t rest = b->valid[base / 64];
#if FRUSTA
    const bool one_way = rest && pktrt__drive_is_coherent(b, base, rest);
    for (uint64_t packet; (packet = pktrt__drive_next_packet(b, base, &rest, one_way)) != 0;)
      pktrt__drive_frustum(scene, b, base, packet, &is);
#endif
    left[base / 64] = rest;
  }
  if (pktrt__batch_note_coherence(b, left, end - begin)) pktrt__drive_octants(scene, b, left, &is);
}

/* >>resolve ---------------------------------------------------------------------------------------------------------

   t, u, v and normal of the hits, once per ray, in double from the corners. The normal's largest component is 1. */

/* Gathers the corners of the triangles that eight rays hit, at the rays' times, of axes k[0], k[1], k[2]. Neighbours mostly
   hit the same triangle, which, at rest or of two keys, is then read once. */
PKTRT__NOINLINE void pktrt__resolve_gather_corners(const pktrt_scene *scene, const uint32_t *slot_of,
                                                   const uint32_t *bvhs, const float *time, uint32_t hits,
                                                   const uint32_t *k, v8 p[3][3]) {
  ROLL_OUT for (int c = 0; c < 9; c++) p[c / 3][c % 3] = vset(0);
  for (uint32_t rest = hits; rest;) {
    const uint32_t r = pktrt__lowest_bit(rest), slot = slot_of[r];
    const pktrt__bvh *bvh = &scene->bvhs[bvhs[r]];
    pktrt__block *block = pktrt__bvh_block(bvh, slot / 8);
    uint32_t lanes = rest & veq_u32(slot_of, slot) & veq_u32(bvhs, bvhs[r]);
    if (!pktrt__has_motion(bvh->key_count)) {
      const float *k0 = &block->vertex[0][0][slot % 8];
      const m8 m = mfrom(lanes);
      for (int c = 0; c < 3; c++, k0 += 24)
        ROLL_OUT for (int a = 0; a < 3; a++) p[c][a] = vsel(m, vset(k0[8 * k[a]]), p[c][a]);
    } else {
      v8 tb = vmin(vmax(vload(time), vset(0)), vset(1)), ta = vsub(vset(1), tb); /* pktrt__time_segment of two keys */
      uint32_t segment = 0;
      if (bvh->key_count > 2) { /* neighbours may be in different segments */
        float a, b;
        segment = pktrt__time_segment(time[r], bvh->key_count, &a, &b);
        lanes = rest & (0u - rest), ta = vset(a), tb = vset(b);
      }
      const float *k0 = pktrt__block_vertices(block, segment) + slot % 8;
      const float *k1 = pktrt__block_vertices(block, segment + 1) + slot % 8;
      const m8 m = mfrom(lanes);
      for (int c = 0; c < 3; c++, k0 += 24, k1 += 24)
        ROLL_OUT for (int a = 0; a < 3; a++) p[c][a] =
            vsel(m, vadd(vmul(ta, vset(k0[8 * k[a]])), vmul(tb, vset(k1[8 * k[a]]))), p[c][a]);
    }
    rest &= ~lanes;
  }
}

/* The matrices of an instance at eight times. */
typedef struct pktrt__place_turn8 {
  d8 m[3][3];
  bool straight; /* as in pktrt__place */
} pktrt__place_turn8;

#if PKTRT__WITH_VECTORS
/* Multiplies eight pairs of edges by them, as pktrt__place_turn does. */
PKTRT__NOINLINE void pktrt__place_turn_edges8(const pktrt__place_turn8 *turn, d8 e[2][3]) {
  for (int c = 0; c < 2; c++) {
    const d8 x = e[c][0], y = e[c][1], z = e[c][2];
    for (int i = 0; i < 3; i++) {
      const d8 *row = turn->m[i];
      e[c][i] = turn->straight ? dmul(row[i], e[c][i]) : dadd(dadd(dmul(row[0], x), dmul(row[1], y)), dmul(row[2], z));
    }
  }
}

/* Turns the axes of eight vectors so that the rays' main axis comes first, where kx and then ky, or else z. */
OP void pktrt__resolve_turn(m8 kx, m8 ky, v8 turned[3]) {
  const v8 x = turned[0], y = turned[1], z = turned[2];
  turned[0] = vsel(kx, x, vsel(ky, y, z));
  turned[1] = vsel(kx, y, vsel(ky, z, x));
  turned[2] = vsel(kx, z, vsel(ky, x, y));
}
/* Returns the axes of eight rays of which those in `hits` have one main axis, else NULL. */
OP const uint32_t *pktrt__resolve_axes(const uint8_t *axis, uint32_t hits) {
  uint64_t all;
  const uint32_t k = axis[pktrt__lowest_bit(hits)];
  memcpy(&all, axis, 8);
  return (all ^ k * UINT64_C(0x0101010101010101)) & vbytes(hits) * 3 ? NULL : pktrt__axes[k];
}

/* Writes t, u, v and normal of rays i to i+7. In an instance, whose matrices at eight times are given, the normal is that of
   edges as the scene has them, no depth is bounded, and what is not calm is left to the caller; returns it. */
SMALL uint32_t pktrt__resolve_hits(const pktrt_scene *scene, pktrt__batch *b, uint32_t i, uint32_t hits,
                                   const pktrt__place_turn8 *turn) {
  const uint32_t *const common = turn ? NULL : pktrt__resolve_axes(b->axis + i, hits), *k = pktrt__axes[0];
  v8 p[3][3], o[3], d[3], turned[3]; /* p[corner][axis] */
  if (common) k = common;
  pktrt__resolve_gather_corners(scene, b->slot + i, b->bvh + i, b->time + i, hits, k, p);
  ROLL_OUT for (int a = 0; a < 3; a++) o[a] = vload(b->o[k[a]] + i), d[a] = vload(b->d[k[a]] + i);
  const v8 ax = vabs(d[0]), ay = vabs(d[1]), az = vabs(d[2]);
  const m8 kx = mand(vle(ay, ax), vle(az, ax)), ky = vle(az, ay); /* as in setup */
  if (!common) pktrt__resolve_turn(kx, ky, o), pktrt__resolve_turn(kx, ky, d);
  d8 x[3], y[3], z[3], e[2][3], n[3];
  ROLL_OUT for (int c = 0; c < 3; c++) {
    ROLL_OUT for (int a = 0; a < 3; a++) turned[a] = p[c][a];
    if (!common) pktrt__resolve_turn(kx, ky, turned);
    pktrt__exact_shear8(turned, o, d, &x[c], &y[c], &z[c]);
  }
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const d8 p0 = dfrom(p[0][a]);
    e[0][a] = dsub(dfrom(p[1][a]), p0);
    e[1][a] = dsub(dfrom(p[2][a]), p0);
  }
  if (PKTRT__INSTANCES && turn) pktrt__place_turn_edges8(turn, e);
  const d8 one = dset(1), dk = dfrom(d[0]);
  const pktrt__exact_edges8 edges = pktrt__exact_edge_functions8(x, y, z);
  ROLL_OUT for (int a = 0; a < 3; a++) n[a] =
      dsub(dmul(e[0][(a + 1) % 3], e[1][(a + 2) % 3]), dmul(e[0][(a + 2) % 3], e[1][(a + 1) % 3]));
  const d8 largest = pktrt__vec_dmax_abs3(n[0], n[1], n[2]), size = pktrt__vec_dmax_abs3(e[0][0], e[0][1], e[0][2]);
  const d8 sizes = dmul(size, pktrt__vec_dmax_abs3(e[1][0], e[1][1], e[1][2]));
  const m8 sharp = dlt(dmul(sizes, dset(PKTRT__CALM_NORMAL)), largest);
  const d8 r = ddiv(one, dmul(edges.det, dk)), rdet = dmul(dk, r), unit = ddiv(one, largest);
  const m8 m = mfrom(hits);
  vstore_masked(b->t + i, m, dto(dmul(edges.depth, r)));
  vstore(b->as.hit.u + i, dto(dmul(edges.v, rdet)));
  vstore(b->as.hit.v + i, dto(dmul(edges.w, rdet)));
  ROLL_OUT for (int a = 0; a < 3; a++) vstore(b->as.hit.normal[k[a]] + i, dto(dmul(n[a], unit)));
  const v8 hi = vload(b->wf + i), range = vsub(hi, vload(b->sf + i));
  uint32_t calm = turn ? 0 : mbits(vlt(vmul(range, vset(PKTRT__CALM_DEPTH)), hi));
  if (PKTRT__UNLIKELY(hits & ~calm)) {
    d8 unread;
    calm |= pktrt__exact_calm8(&edges, x, y, z, dk, &unread);
  }
  hits &= ~(calm & mbits(sharp));
  if (PKTRT__UNLIKELY(hits) && !turn) pktrt__single_resolve_hits(scene, b, i, hits);
  return hits;
}
#else
OP uint32_t pktrt__resolve_hits(const pktrt_scene *scene, pktrt__batch *b, uint32_t i, uint32_t hits,
                                const pktrt__place_turn8 *turn) {
  (void)turn;
  pktrt__single_resolve_hits(scene, b, i, hits);
  return 0;
}
#endif

/* Writes PKTRT_NONE to those of rays i to i+7 that hit nothing, and zeros. */
OP void pktrt__resolve_misses(pktrt__batch *b, uint32_t i, uint32_t hits) {
  if (hits == 0xFF) return;
  const m8 missed = mfrom(0xFFu & ~hits);
  vstore_masked_u32(b->id + i, missed, PKTRT_NONE);
  vstore_masked(b->as.hit.u + i, missed, vset(0)), vstore_masked(b->as.hit.v + i, missed, vset(0));
  UNROLL for (int a = 0; a < 3; a++) vstore_masked(b->as.hit.normal[a] + i, missed, vset(0));
}

static void pktrt__resolve_batch(const pktrt__query *call, pktrt__batch *b, uint32_t begin, uint32_t end) {
  const pktrt_scene *scene = call->scene;
  for (uint32_t i = begin; i < end; i += 8) {
    if (call->place && i + 8 <= end) pktrt__prefetch_lines(call->place + i, 8 * sizeof *call->place);
    const uint32_t hits = pktrt__lanes_occupied(b->slot + i);
    const uint32_t placed = pktrt__has_instances(scene) ? hits & ~veq_u32(b->place + i, 0) : 0;
    if (hits & ~placed) pktrt__resolve_hits(scene, b, i, hits & ~placed, NULL);
#if !defined(PKTRT_NO_INSTANCES)
    for (uint32_t rest = placed; rest;) {
      const uint32_t place = b->place[i + pktrt__lowest_bit(rest)];
      uint32_t same = rest & veq_u32(b->place + i, place);
#if PKTRT__WITH_V8_REGISTERS
      const pktrt__instance *in = &scene->instances[place - 1];
      for (uint32_t m = pktrt__has_motion(in->key_count) ? 0 : rest & ~same; m; m &= m - 1) {
        const pktrt__instance *other = &scene->instances[b->place[i + pktrt__lowest_bit(m)] - 1];
        const bool alike = other->model == in->model && other->rest.straight == in->rest.straight;
        if (alike && !pktrt__has_motion(other->key_count)) same |= m & (0u - m);
      }
      rest &= ~same;
      if (pktrt__popcount8(same) > 2 && in->key_count < 3) { /* else one by one is as fast */
        pktrt__place_resolve8(scene, b, i, same);
        continue;
      }
#else
      rest &= ~same;
#endif
      pktrt__place_resolve_hits(scene, b, i, same);
    }
#endif
    pktrt__resolve_misses(b, i, hits);
  }
}

#if !defined(PKTRT_NO_RENDER) && PKTRT__WITH_SHADE
/* >>shade ---------------------------------------------------------------------------------------------------------- */

STEP v8 pktrt__vec_dot(const v8 a[3], const v8 b[3]) {
  return vadd(vadd(vmul(a[0], b[0]), vmul(a[1], b[1])), vmul(a[2], b[2]));
}
STEP d8 pktrt__vec_ddot(const d8 a[3], const d8 b[3]) {
  d8 sum = dset(0);
  ROLL_OUT for (int k = 0; k < 3; k++) sum = dadd(sum, dmul(a[k], b[k]));
  return sum;
}
STEP void pktrt__vec_dset3(d8 a[3], const double *p) { ROLL_OUT for (int k = 0; k < 3; k++) a[k] = dset(p[k]); }
STEP void pktrt__vec_dload3(d8 a[3], double (*p)[PKTRT__ROW], uint32_t i) {
  ROLL_OUT for (int k = 0; k < 3; k++) a[k] = dload(p[k] + i);
}
STEP void pktrt__vec_dfrom3(d8 a[3], float (*p)[PKTRT__ROW], uint32_t i) {
  ROLL_OUT for (int k = 0; k < 3; k++) a[k] = dfrom(vload(p[k] + i));
}
STEP void pktrt__vec_load3(v8 a[3], float (*p)[PKTRT__ROW], uint32_t i) {
  ROLL_OUT for (int k = 0; k < 3; k++) a[k] = vload(p[k] + i);
}
STEP void pktrt__vec_store3(float (*p)[PKTRT__ROW], uint32_t i, const v8 a[3]) {
  ROLL_OUT for (int k = 0; k < 3; k++) vstore(p[k] + i, a[k]);
}

/* Normalises eight vectors, scaled first: squares may leave the range. Zero, infinite and NaN ones become `instead`. */
STEP void pktrt__vec_normalise(v8 a[3], const v8 instead[3]) {
  const v8 m = vmax(vabs(a[0]), vmax(vabs(a[1]), vabs(a[2])));
  v8 s[3];
  ROLL_OUT for (int k = 0; k < 3; k++) s[k] = vdiv(a[k], m);
  const v8 length = vsqrt(pktrt__vec_dot(s, s));
  const m8 good = mand(vlt(vset(0.5f), length), vlt(length, vset(2)));
  ROLL_OUT for (int k = 0; k < 3; k++) a[k] = vsel(good, vdiv(s[k], length), instead[k]);
}

/* Here samples are drawn PKTRT__DRAWN at once: compilers vectorise loops of known length. */

/* Finds the points of Sobol's net that samples take, see pktrt__sampler_point_index. If n is 2^k, all are permuted at
   once, for the product with n in pktrt__sampler_rotate is then a shift; else one by one. */
OP void pktrt__sampler_shuffle(uint32_t n, const uint32_t *sample, const uint32_t *group, const uint64_t *key,
                               uint32_t *at) {
  const uint32_t width = pktrt__bit_width(n - 1), ones = (1u << width) - 1, shift = (width + 1) / 2;
  uint32_t any = 0;
  for (int j = 0; j < PKTRT__DRAWN; j++) any |= group[j], at[j] = sample[j];
  if (!any) return;
  if (n & (n - 1)) {
    for (int j = 0; j < PKTRT__DRAWN; j++) at[j] = pktrt__sampler_point_index(group[j], sample[j], n, key[j]);
    return;
  }
  for (int j = 0; j < PKTRT__DRAWN; j++) {
    const uint32_t turn = ((uint32_t)key[j] * 0x9E3779B9u + (uint32_t)(key[j] >> 32)) >> (32 - width) % 32;
    at[j] = group[j] ? (pktrt__sampler_permute_rounds(at[j], ones, shift, key[j]) + turn) & ones : at[j];
  }
}

/* Computes the digits of the third and fourth coordinates of Sobol's points, as in pktrt__sampler_net. */
OP void pktrt__sampler_second_pairs(uint32_t n, const uint32_t *at, uint32_t *x, uint32_t *y) {
  for (int j = 0; j < PKTRT__DRAWN; j++) x[j] = y[j] = 0;
  for (uint32_t k = 0; (n - 1) >> k; k++) {
    const uint32_t third = pktrt__sampler_third[k];
    for (int j = 0; j < PKTRT__DRAWN; j++) {
      const uint32_t bit = at[j] >> k & 1;
      x[j] += x[j] + bit, y[j] ^= (0u - bit) & third;
    }
  }
  for (int j = 0; (n & (n - 1)) && j < PKTRT__DRAWN; j++) x[j] = pktrt__sampler_digits(at[j], n);
}
OP void pktrt__sampler_scramble_rows(const uint32_t *x, const uint32_t *key, float *out) {
  uint32_t bits[PKTRT__DRAWN];
  for (int j = 0; j < PKTRT__DRAWN; j++) bits[j] = pktrt__reverse_bits(pktrt__sampler_owen(x[j], key[j]));
  for (int j = 0; j < PKTRT__DRAWN; j++) out[j] = pktrt__sampler_unit(bits[j]);
}
OP void pktrt__sampler_split_halves(const uint64_t *both, uint32_t *low, uint32_t *high) {
  for (int j = 0; j < PKTRT__DRAWN; j++) low[j] = (uint32_t)both[j], high[j] = (uint32_t)(both[j] >> 32);
}

static void pktrt__sampler_draw(const pktrt_sampling *s, pktrt__sample_batch *w, uint32_t i, uint32_t group,
                                uint32_t first, uint32_t n) {
  const bool sobol = pktrt__sampler_rows[s->sampler].drawn == PKTRT__DRAWN_SOBOL;
  const uint32_t *const sample = w->sample + i, *const x = w->x + i, *const y = w->y + i, *const of = w->group + i;
  uint32_t number[PKTRT__DRAWN], at[PKTRT__DRAWN], low[PKTRT__DRAWN], high[PKTRT__DRAWN], digits[2][PKTRT__DRAWN];
  uint64_t key[PKTRT__DRAWN], keys[PKTRT__DRAWN];
  for (int j = 0; j < PKTRT__DRAWN; j++) number[j] = (of[j] + group) & (UINT32_MAX >> 2);
  for (int j = 0; j < PKTRT__DRAWN; j++) key[j] = pktrt__sampler_key(s->seed, number[j], x[j], y[j]);
  if (sobol) pktrt__sampler_shuffle(s->samples, sample, number, key, at);
  for (uint32_t pair = first & 2; pair < first + n; pair += 2) {
    float *const u = w->u[pair] + i, *const v = w->u[pair + 1] + i;
    if (sobol) {
      for (int j = 0; j < PKTRT__DRAWN; j++) digits[0][j] = at[j], digits[1][j] = pktrt__sampler_pascal(at[j]);
      if (pair) pktrt__sampler_second_pairs(s->samples, at, digits[0], digits[1]);
      for (int j = 0; j < PKTRT__DRAWN; j++) keys[j] = pktrt__hash(key[j] + pair);
      pktrt__sampler_split_halves(keys, low, high);
      pktrt__sampler_scramble_rows(digits[0], high, u), pktrt__sampler_scramble_rows(digits[1], low, v);
    } else {
      for (int j = 0; j < PKTRT__DRAWN; j++) keys[j] = pktrt__hash(key[j] + 2 * (uint64_t)sample[j] + pair / 2);
      pktrt__sampler_split_halves(keys, low, high);
      for (int j = 0; j < PKTRT__DRAWN; j++) u[j] = pktrt__sampler_unit(low[j]), v[j] = pktrt__sampler_unit(high[j]);
    }
  }
}

/* Makes the rays of a pinhole camera through eight places of the picture. */
static void pktrt__camera_rays8(const pktrt__camera_plane *p, const double *x, const double *y, pktrt__wave *w,
                                uint32_t i) {
  const d8 px = dload(x), py = dload(y);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const d8 across = dadd(dset(p->corner[a]), dmul(px, dset(p->dx[a])));
    vstore(w->rays.o[a] + i, dto(dset(p->eye[a])));
    vstore(w->rays.d[a] + i, dto(dadd(across, dmul(py, dset(p->dy[a])))));
  }
}

OP uint32_t pktrt__lanes_first(uint32_t n) { return n < 8 ? 0xFFu >> (8 - n) : 0xFFu; } /* the first n of eight */

static void pktrt__surface_pack(pktrt__wave *w, uint32_t first, uint32_t n, pktrt__surfaces *s) {
  pktrt__batch *b = &w->rays;
  float(*const normal)[PKTRT__ROW] = b->as.hit.normal;
  void *const rows[] = {b->o[0],   b->o[1],   b->o[2],  b->d[0],       b->d[1],     b->d[2], normal[0],
                        normal[1], normal[2], b->t,     b->as.hit.u,   b->as.hit.v, b->time, b->id,
                        b->slot,   b->bvh,    b->place, w->importance, w->medium,   w->key,  w->root};
  uint32_t k = 0;
  for (uint32_t i = 0; i < n; i += 8) {
    const uint32_t from = first + i, to = first + k, all = pktrt__lanes_first(n - i);
    const uint32_t hits = all & pktrt__lanes_occupied(b->slot + from);
    const c8 chosen = vchoose(hits);
    vcompress_from(s->ray + k, chosen, s->number + from);
    k += pktrt__popcount8(hits);
    if (from == to && hits == all) continue;
    for (size_t row = 0; row < sizeof rows / sizeof *rows; row++) {
      char *data = PKTRT__CAST(char *, rows[row]), *end = data + to * sizeof(float);
      if (all == 0xFF) vcompress_from(end, chosen, data + from * sizeof(float));
      else /* rays behind these are still to be packed */
        for (uint32_t m = hits; m; m &= m - 1, end += sizeof(float))
          memmove(end, data + (from + pktrt__lowest_bit(m)) * sizeof(float), sizeof(float));
    }
  }
  s->first = first, s->count = k;
}

/* Gathers the vertex normals of the triangles of surfaces i to i + 7; n if there are none. Tells whether any has. */
PKTRT__NOINLINE bool pktrt__surface_gather_normals(const pktrt_scene *scene, const float *time,
                                                   const pktrt__surfaces *s, uint32_t i, uint32_t lanes, const v8 n[3],
                                                   v8 q[3][3]) {
  bool any = false;
  ROLL_OUT for (int c = 0; c < 9; c++) q[c / 3][c % 3] = n[c % 3];
  for (uint32_t rest = lanes; rest;) {
    const uint32_t r = pktrt__lowest_bit(rest), triangle = s->triangle[i + r];
    const pktrt__mesh *mesh = pktrt__mesh_source(scene, s->mesh[i + r]);
    const bool placed = scene->meshes[s->mesh[i + r]].instance != 0;
    uint32_t same = rest & veq_u32(s->mesh + i, s->mesh[i + r]);
    if (mesh->normals) {
      float corner[3][3];
      any = true;
      same = !placed && !pktrt__has_motion(mesh->key_count) ? same & veq_u32(s->triangle + i, triangle)
                                                            : rest & (0u - rest);
      const m8 m = mfrom(same);
      if (!placed && !pktrt__has_motion(mesh->key_count) && mesh->indices) {
        const uint32_t *v = mesh->indices + (size_t)triangle * 3;
        UNROLL for (int c = 0; c < 3; c++) {
          const float *k = mesh->normals + (size_t)v[c] * 3;
          UNROLL for (int a = 0; a < 3; a++) q[c][a] = vsel(m, vset(k[a]), q[c][a]);
        }
        rest &= ~same;
        continue;
      }
      if (placed) pktrt__surface_place_normals(scene, s->mesh[i + r], triangle, time[r], corner);
      else
        for (uint32_t c = 0; c < 3; c++) pktrt__mesh_corner_at(mesh, mesh->normals, triangle, c, time[r], corner[c]);
      ROLL_OUT for (int c = 0; c < 9; c++) q[c / 3][c % 3] = vsel(m, vset(corner[c / 3][c % 3]), q[c / 3][c % 3]);
    }
    rest &= ~same;
  }
  return any;
}

/* Finds the points of surfaces i to i + 7 by their corners and edges, as pktrt__spawn_find does. Returns B of >>spawn. */
STEP d8 pktrt__surface_point8(const pktrt__batch *b, uint32_t at, const v8 p0[3], d8 e[2][3], pktrt__surfaces *s,
                              uint32_t i) {
  const d8 u = dfrom(vload(b->as.hit.u + at)), v = dfrom(vload(b->as.hit.v + at)), t = dfrom(vload(b->t + at));
  d8 q[3], n[3], sum = dset(0);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const d8 way = dmul(t, dfrom(vload(b->d[a] + at))), by_t = dadd(dfrom(vload(b->o[a] + at)), way);
    const m8 nearer =
        dlt(dmul(dset(PKTRT__ERROR_T), dabs(way)), dmul(dset(PKTRT__ERROR_UV), dadd(dabs(e[0][a]), dabs(e[1][a]))));
    q[a] = dsel(nearer, dsub(by_t, dfrom(p0[a])), dadd(dmul(u, e[0][a]), dmul(v, e[1][a])));
  }
  UNROLL for (int a = 0; a < 3; a++) n[a] =
      dsub(dmul(e[0][(a + 1) % 3], e[1][(a + 2) % 3]), dmul(e[0][(a + 2) % 3], e[1][(a + 1) % 3]));
  const d8 most = pktrt__vec_dmax_abs3(n[0], n[1], n[2]);
  const d8 size =
      dmul(pktrt__vec_dmax_abs3(e[0][0], e[0][1], e[0][2]), pktrt__vec_dmax_abs3(e[1][0], e[1][1], e[1][2]));
  const m8 sharp = dlt(dmul(size, dset(PKTRT__CALM_NORMAL)), most);
  ROLL_OUT for (int a = 0; a < 3; a++) n[a] = dsel(sharp, n[a], dfrom(vload(b->as.hit.normal[a] + at)));
  const d8 along = ddiv(dadd(dadd(dmul(n[0], q[0]), dmul(n[1], q[1])), dmul(n[2], q[2])),
                        dadd(dadd(dmul(n[0], n[0]), dmul(n[1], n[1])), dmul(n[2], n[2])));
  ROLL_OUT for (int a = 0; a < 3; a++) {
    q[a] = dsub(q[a], dmul(along, n[a]));
    const d8 point = dadd(dfrom(p0[a]), q[a]);
    dstore(s->point[a] + i, point), vstore(s->position[a] + i, dto(point));
    sum = dadd(sum, dadd(dabs(q[a]), dabs(point)));
  }
  const d8 known = dmax(ddiv(dmul(dset(PKTRT__ERROR_PLANE), size), dmax(most, dset(DBL_EPSILON * FLT_MIN))),
                        dset(PKTRT__ERROR_LEAST));
  return dmul(sum, dsel(sharp, known, dset(PKTRT__ERROR_NEEDLE)));
}

/* Computes how far rays start from surfaces i to i + 7, of unit normals n: h of >>spawn, or where nobody sees it more, so
   that they start outside the leaf that they left, which every box is wide enough to take for theirs. WHY 6e-6: of the
   way that the ray came, less than a fiftieth of a pixel. Without it pictures of mirrors took a fifth longer. */
STEP void pktrt__surface_offset8(float largest, const v8 n[3], d8 bound, pktrt__surfaces *s, uint32_t i) {
  d8 rounding = dset(0);
  ROLL_OUT for (int a = 0; a < 3; a++) rounding = dadd(rounding, dabs(dmul(dfrom(n[a]), dload(s->point[a] + i))));
  const d8 offset = dmul(dset(1.0078125), dadd(dmul(dset((double)PKTRT__EPS), rounding), bound));
  const v8 more = vmin(vset(24 * PKTRT__EPS * largest), vmul(vset(5.7220458984375e-6f), vload(s->distance + i)));
  vstore(s->offset + i, vmax(dto(dadd(offset, dset(FLT_MIN * PKTRT__ERROR_NEEDLE))), more));
}

/* Computes the origins of rays that leave surfaces i to i + 7 along ng (side 1) or against it (side -1). */
STEP void pktrt__surface_start(const pktrt__surfaces *s, uint32_t i, double side, v8 o[3]) {
  const d8 offset = dmul(dfrom(vload(s->offset + i)), dset(side));
  ROLL_OUT for (int a = 0; a < 3; a++) o[a] =
      dto(dadd(dload(s->point[a] + i), dmul(offset, dfrom(vload(s->ng[a] + i)))));
}

/* Computes points and normals of surfaces i to i + 7, of which those in `lanes` exist. */
PKTRT__NOINLINE void pktrt__surface_find8(const pktrt_scene *scene, bool smooth, const pktrt__wave *w,
                                          pktrt__surfaces *s, uint32_t i, uint32_t lanes) {
  const pktrt__batch *b = &w->rays;
  const uint32_t at = s->first + i;
  const v8 u = vload(b->as.hit.u + at), v = vload(b->as.hit.v + at), zero = vset(0);
  v8 p[3][3], n[3], d[3], q[3];
  d8 e[2][3], length2 = dset(0);
  const uint32_t placed =
      pktrt__has_instances(scene) ? lanes & ~veq_u32(b->place + at, 0) : 0; /* their points come last */
  pktrt__resolve_gather_corners(scene, b->slot + at, b->bvh + at, b->time + at, lanes & ~placed, pktrt__axes[0], p);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const d8 p0 = dfrom(p[0][a]);
    e[0][a] = dsub(dfrom(p[1][a]), p0), e[1][a] = dsub(dfrom(p[2][a]), p0);
    n[a] = vload(b->as.hit.normal[a] + at), d[a] = vload(b->d[a] + at);
    length2 = dadd(length2, dmul(dfrom(d[a]), dfrom(d[a])));
  }
  const d8 bound = pktrt__surface_point8(b, at, p[0], e, s, i);
  vstore(s->distance + i, dto(dmul(dfrom(vload(b->t + at)), dsqrt(length2))));
  const bool bent = smooth && pktrt__surface_gather_normals(scene, b->time + at, s, i, lanes, n, p);
  if (bent) {
    ROLL_OUT for (int a = 0; a < 3; a++) q[a] =
        vadd(p[0][a], vadd(vmul(u, vsub(p[1][a], p[0][a])), vmul(v, vsub(p[2][a], p[0][a]))));
  }
  pktrt__vec_normalise(n, n);
  if (!bent) { /* as if it were blended of three: zeros are positive */
    ROLL_OUT for (int a = 0; a < 3; a++) q[a] = vadd(n[a], zero);
  }
  pktrt__vec_normalise(d, d);
  const m8 inside = vlt(zero, pktrt__vec_dot(n, d));
  ROLL_OUT for (int a = 0; a < 3; a++) n[a] = vsel(inside, vsub(zero, n[a]), n[a]);
  if (bent) pktrt__vec_normalise(q, n);
  const m8 turned = vlt(pktrt__vec_dot(q, n), zero);
  ROLL_OUT for (int a = 0; a < 3; a++) q[a] = vsel(turned, vsub(zero, q[a]), q[a]);
  const m8 away = vle(zero, pktrt__vec_dot(q, d));
  pktrt__vec_store3(s->ng, i, n);
  pktrt__vec_store3(s->ns, i, q);
  pktrt__vec_store3(s->d, i, d);
  ROLL_OUT for (int a = 0; a < 3; a++) vstore(s->nf[a] + i, vsel(away, n[a], q[a]));
  s->inside[i / 8] = (uint8_t)mbits(inside);
  pktrt__surface_offset8(scene->largest, n, bound, s, i);
  for (uint32_t m = placed; m; m &= m - 1) pktrt__surface_place(scene, w, s, i + pktrt__lowest_bit(m));
  pktrt__surface_start(s, i, 1, p[0]);
  pktrt__vec_store3(s->start, i, p[0]);
}

/* Reads the materials of surfaces i to i + 7, before hooks and the viewing angle change their values. */
PKTRT__NOINLINE void pktrt__surface_read_materials(const pktrt_scene *scene, pktrt__surfaces *s, uint32_t i,
                                                   uint32_t lanes) {
  v8 albedo[3], reflectance[3], emission[3], eta = vset(1);
  uint32_t shaded = 0, hooked = 0, lobed = 0, bare = 0, kind[PKTRT_SPECULAR_COUNT] = {0};
  ROLL_OUT for (int a = 0; a < 3; a++) albedo[a] = reflectance[a] = emission[a] = vset(0);
  for (uint32_t rest = lanes; rest;) {
    const uint32_t material = s->material[i + pktrt__lowest_bit(rest)],
                   same = rest & veq_u32(s->material + i, material);
    const pktrt_material *mat = pktrt__material_of(scene, material);
    const bool tinted = mat->reflectance[0] > 0 || mat->reflectance[1] > 0 || mat->reflectance[2] > 0;
    const bool own = tinted || pktrt__specular_rows[mat->specular].takes;
    const float ior = pktrt__material_ior(mat, 0);
    const m8 m = mfrom(same), within = mfrom(mat->specular == PKTRT_SPECULAR_DIELECTRIC ? s->inside[i / 8] : 0u);
    ROLL_OUT for (int a = 0; a < 3; a++) {
      albedo[a] = vsel(m, vset(mat->albedo[a]), albedo[a]);
      emission[a] = vsel(m, vset(mat->emission[a]), emission[a]);
      reflectance[a] = vsel(m, vset(own ? mat->reflectance[a] : 1), reflectance[a]);
    }
    eta = vsel(m, vsel(within, vset(1 / ior), vset(ior)), eta);
    kind[mat->specular] |= same;
    shaded |= mat->shader ? same : 0, hooked |= mat->shader || mat->texture ? same : 0;
    lobed |= pktrt__material_has_lobe(mat) ? same : 0, bare |= pktrt__specular_rows[mat->specular].bare ? same : 0;
    rest &= ~same;
  }
  pktrt__vec_store3(s->albedo, i, albedo);
  pktrt__vec_store3(s->reflectance, i, reflectance);
  pktrt__vec_store3(s->emission, i, emission);
  vstore(s->eta + i, eta);
  kind[PKTRT_SPECULAR_NONE] |= ~lanes; /* lanes without a surface need no work */
  for (int k = 0; k < PKTRT_SPECULAR_COUNT; k++) s->kind[k][i / 8] = (uint8_t)kind[k];
  s->shaded[i / 8] = (uint8_t)shaded, s->hooked[i / 8] = (uint8_t)hooked, s->lobed[i / 8] = (uint8_t)lobed;
  s->bare[i / 8] = (uint8_t)bare;
}

static void pktrt__surface_find(const pktrt_scene *scene, bool smooth, const pktrt__wave *w, pktrt__surfaces *s) {
  for (uint32_t i = 0; i < s->count; i += 8) {
    const uint32_t lanes = pktrt__lanes_first(s->count - i);
    pktrt__surface_find8(scene, smooth, w, s, i, lanes);
    pktrt__surface_read_materials(scene, s, i, lanes);
  }
}

#if PKTRT__WITH_PAPER
/* Computes k = eta^2 - (1 - c^2), where c is the cosine before a surface and sqrt(k) / eta the one behind it: for small
   eta as eta^2 - (1 - c) (1 + c), which is accurate head on, else as c^2 + (eta^2 - 1), accurate at grazing angles. The
   differences of squares are products. */
OP v8 pktrt__material_cosine_behind(v8 c, v8 eta) {
  const v8 one = vset(1), more = vmul(vsub(eta, one), vadd(eta, one)), less = vmul(vsub(one, c), vadd(one, c));
  return vsel(vlt(eta, vset(0.5f)), vsub(vmul(eta, eta), less), vadd(vmul(c, c), more));
}

/* Computes mirror and refracted directions and Fresnel reflectance of surfaces i to i + 7, whose eta is set. With c the
   cosine before the surface and c' the one behind it, R is the mean of ((c - eta c') / (c + eta c'))^2 and
   ((eta c - c') / (eta c + c'))^2; no real c' is total reflection. A direction on the wrong side of the triangle, which
   smooth normals can cause, is computed again about the geometric normal. */
STEP void pktrt__material_scatter(pktrt__surfaces *s, uint32_t i) {
  v8 d[3], n[3], f[3], r[3], t[3];
  pktrt__vec_load3(d, s->d, i);
  pktrt__vec_load3(n, s->nf, i);
  pktrt__vec_load3(f, s->ng, i);
  const v8 zero = vset(0), one = vset(1), eta = vload(s->eta + i);
  const v8 c = vmin(one, vsub(zero, pktrt__vec_dot(d, n))), cf = vmin(one, vsub(zero, pktrt__vec_dot(d, f)));
  ROLL_OUT for (int a = 0; a < 3; a++) r[a] = vadd(d[a], vmul(vadd(c, c), n[a]));
  const m8 below = vle(pktrt__vec_dot(r, f), zero);
  ROLL_OUT for (int a = 0; a < 3; a++) r[a] = vsel(below, vadd(d[a], vmul(vadd(cf, cf), f[a])), r[a]);
  pktrt__vec_normalise(r, f);
  pktrt__vec_store3(s->mirror, i, r);
  const v8 k = pktrt__material_cosine_behind(c, eta), c2 = vdiv(vsqrt(vmax(k, zero)), eta);
  const v8 kf = pktrt__material_cosine_behind(cf, eta), cf2 = vdiv(vsqrt(vmax(kf, zero)), eta);
  const v8 ec = vmul(eta, c), ec2 = vmul(eta, c2);
  const v8 rs = vdiv(vsub(c, ec2), vadd(c, ec2)), rp = vdiv(vsub(ec, c2), vadd(ec, c2));
  vstore(s->fresnel + i, vsel(vlt(zero, k), vmul(vset(0.5f), vadd(vmul(rs, rs), vmul(rp, rp))), one));
  const v8 along = vsub(vdiv(c, eta), c2), along_f = vsub(vdiv(cf, eta), cf2);
  ROLL_OUT for (int a = 0; a < 3; a++) t[a] = vadd(vdiv(d[a], eta), vmul(along, n[a]));
  const m8 above = vle(zero, pktrt__vec_dot(t, f));
  ROLL_OUT for (int a = 0; a < 3; a++) t[a] = vsel(above, vadd(vdiv(d[a], eta), vmul(along_f, f[a])), t[a]);
  pktrt__vec_normalise(t, d);
  pktrt__vec_store3(s->refracted, i, t);
}

/* Computes weights of reflection, refraction and base of eight surfaces; metals: pktrt__material_weights_rest. */
PKTRT__NOINLINE void pktrt__material_weights8(pktrt__surfaces *s, uint32_t i) {
  const uint32_t live = ~(uint32_t)s->shaded[i / 8], glossy = live & ~(uint32_t)s->kind[PKTRT_SPECULAR_NONE][i / 8];
  const v8 zero = vset(0), one = vset(1);
  if (!(glossy & 0xFF)) {
    for (int a = 0; a < 3; a++) vstore(s->reflected[a] + i, zero), vstore(s->transmitted[a] + i, zero);
    return;
  }
  pktrt__material_scatter(s, i);
  const v8 fresnel = vload(s->fresnel + i), rest = vsub(one, fresnel);
  const m8 mirror = mfrom(s->kind[PKTRT_SPECULAR_MIRROR][i / 8] & live);
  const m8 coat = mfrom(s->kind[PKTRT_SPECULAR_COAT][i / 8] & live);
  const m8 glass = mfrom(s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8] & live);
  const m8 bare = mfrom(s->bare[i / 8] & live);
  const v8 factor = vsel(mirror, one, vsel(mor(coat, glass), fresnel, zero));
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const v8 albedo = vload(s->albedo[a] + i);
    vstore(s->reflected[a] + i, vmul(factor, vload(s->reflectance[a] + i)));
    vstore(s->transmitted[a] + i, vsel(glass, rest, zero));
    vstore(s->albedo[a] + i, vsel(bare, zero, vsel(coat, vmul(albedo, rest), albedo)));
  }
}

static void pktrt__material_evaluate(const pktrt_scene *scene, const pktrt__glass_mesh *meshes, bool follow,
                                     const float ambient[3], const pktrt__wave *w, pktrt__surfaces *s) {
  for (uint32_t i = 0; i < s->count; i += 8) {
    const uint32_t lanes = pktrt__lanes_first(s->count - i), lit = ~(uint32_t)s->shaded[i / 8];
    if (follow) {
      const uint32_t metal = PKTRT__CONDUCTOR ? s->kind[PKTRT_SPECULAR_CONDUCTOR][i / 8] & lit : 0;
      const uint32_t inside = s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8] & s->inside[i / 8];
      const uint32_t glass = PKTRT__DIELECTRIC ? lanes & (inside | ~veq_u32(w->medium + s->first + i, 0)) : 0;
      pktrt__material_weights8(s, i);
      if (metal | glass) pktrt__material_weights_rest(scene, meshes, w, s, i, metal, glass);
    }
    for (int a = 0; a < 3; a++) {
      const v8 around = vsel(mfrom(lit & 0xFF), vmul(vload(s->albedo[a] + i), vset(ambient[a])), vset(0));
      vstore(s->radiance[a] + i, vadd(vload(s->emission[a] + i), around));
    }
    s->lit[i / 8] = (uint8_t)(lanes & lit & (follow ? ~(uint32_t)s->bare[i / 8] | s->lobed[i / 8] : ~0u));
  }
}
#define PKTRT__MATERIAL_EVALUATE pktrt__material_evaluate
#else
#define PKTRT__MATERIAL_EVALUATE pktrt__material_evaluate_avx2
#endif

/* Finds the point `at` of a light for surfaces i to i + 7 at p. Returns the irradiance of what faces it there, without
   a quad's cosine. For a mesh the point lies on the line to its middle, outside the sphere around it; a surface in the
   middle itself gets NaN and is not lit. */
STEP d8 pktrt__light_locate(const pktrt__light_target *l, uint32_t i, d8 p[3], d8 at[3]) {
  d8 to[3], facing[3];
  if (l->listed) {
    ROLL_OUT for (int a = 0; a < 3; a++) at[a] = dload(l->listed->at[a] + i);
    return dload(l->listed->factor + i);
  }
  pktrt__vec_dset3(at, l->at);
  if (!PKTRT__AREA_LIGHTS || !l->emissive) return dset(l->strength);
  ROLL_OUT for (int a = 0; a < 3; a++) to[a] = dsub(at[a], p[a]);
  pktrt__vec_dset3(facing, l->facing);
  const d8 r2 = pktrt__vec_ddot(to, to), r = dsqrt(r2), along = pktrt__vec_ddot(to, facing);
  const d8 outside = dmax(dsub(dset(1), ddiv(dset(l->radius), r)), dset(1.0 / 1024));
  ROLL_OUT for (int a = 0; a < 3; a++) at[a] = dadd(p[a], dmul(outside, to[a]));
  return dmul(ddiv(dadd(ddiv(dabs(along), r), dset(l->folded)), r2), dset(l->strength));
}

/* Appends the shadow rays of surfaces i to i + 7 to the list, from s->start: off along ng, on the viewer's side. */
PKTRT__NOINLINE void pktrt__light_shadow_rays8(const pktrt_scene *scene, const pktrt__light_target *l,
                                               const pktrt__wave *w, pktrt__surfaces *s, uint32_t i, uint32_t lanes,
                                               pktrt__shadow_rays *sh) {
  d8 to[3], p[3], at[3], flat[3], shade[3];
  v8 o[3], d[3], arriving[3], through[3], lobe = vset(0), largest = vset(0);
  pktrt__vec_load3(o, s->start, i);
  pktrt__vec_dload3(p, s->point, i);
  pktrt__vec_dfrom3(flat, s->ng, i);
  pktrt__vec_dfrom3(shade, s->ns, i);
  d8 factor = pktrt__light_locate(l, i, p, at);
  if (l->listed) lanes &= mbits(dlt(dset(0), factor)); /* the others have no point on a light */
  ROLL_OUT for (int a = 0; a < 3; a++) {
    to[a] = l->infinite ? at[a] : dsub(at[a], p[a]);
    d[a] = dto(l->infinite ? at[a] : dsub(at[a], dfrom(o[a])));
  }
  lanes &= mbits(dlt(dset(0), pktrt__vec_ddot(to, flat)));
  if (!lanes) return; /* all face away from it */
  const d8 r2 = pktrt__vec_ddot(to, to), r = dsqrt(r2);
  if (PKTRT__AREA_LIGHTS && l->flat && !l->listed) { /* negative behind it */
    pktrt__vec_dset3(at, l->facing);
    factor = dmul(ddiv(dmul(dset(-l->area), pktrt__vec_ddot(to, at)), r), factor);
  }
  const d8 irradiance = l->by_square ? ddiv(factor, r2) : factor, cosine = ddiv(pktrt__vec_ddot(to, shade), r);
  v8 diffuse = dto(dmul(dmul(dmax(dset(0), cosine), irradiance), dset(0.31830988618379067154)));
  lanes &= mbits(dlt(dset(0), irradiance));
  if (PKTRT__GLOSS && l->lobes && (lanes & s->lobed[i / 8])) {
    float axis[3][8], part[8];
    ROLL_OUT for (int a = 0; a < 3; a++) vstore(axis[a], dto(ddiv(to[a], r)));
    vstore(part, dto(irradiance));
    pktrt__light_lobe_values(scene, s, i, lanes & s->lobed[i / 8], axis, l->listed, part);
    lobe = vload(part);
  }
  if (PKTRT__GLOSS && l->lobes_only) diffuse = vset(0);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const v8 light = l->listed ? vload(l->listed->arriving[a] + i) : vset(l->arriving[a]);
    const v8 specular = vload(s->reflected[a] + i), base = vmul(vload(s->albedo[a] + i), diffuse);
    arriving[a] = vmul(vadd(base, PKTRT__GLOSS && l->lobes ? vmul(specular, lobe) : vset(0)), light);
    through[a] = PKTRT__GLOSS && l->glass_stops ? vmul(base, light) : arriving[a];
    largest = vmax(largest, arriving[a]);
  }
  lanes &= mbits(vlt(vset(0), largest));
  const uint32_t n = sh->count;
  const c8 chosen = vchoose(lanes);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    vcompress(sh->o[a] + n, chosen, o[a]);
    vcompress(sh->d[a] + n, chosen, d[a]);
    vcompress(sh->contribution[a] + n, chosen, arriving[a]);
    if (PKTRT__GLOSS && sh->through[0]) vcompress(sh->through[a] + n, chosen, through[a]);
  }
  vcompress_from(sh->time + n, chosen, w->rays.time + s->first + i);
  vcompress_from(sh->surface + n, chosen, s->number + i);
  if (sh->material) vcompress_from(sh->material + n, chosen, s->material + i);
  if (sh->tmax_row) vstore(sh->tmax_row + n, vset(sh->tmax));
  sh->count += pktrt__popcount8(lanes);
}

static void pktrt__light_shadow_rays(const pktrt_scene *scene, const pktrt__light_target *l, const pktrt__wave *w,
                                     pktrt__surfaces *s, pktrt__shadow_rays *sh) {
  sh->count = 0, sh->tmax = l->infinite ? INFINITY : 1;
  for (uint32_t i = 0; i < s->count; i += 8)
    if (s->lit[i / 8]) pktrt__light_shadow_rays8(scene, l, w, s, i, s->lit[i / 8], sh);
}

#if PKTRT__WITH_FIT
/* Here eight surfaces sample a light. Each step does operation by operation what its namesake does for one, so that one
   may take the place of the other. */

/* Turns p[0] to sine and cosine, as pktrt__math_sincos does. */
SMALL void pktrt__vec_sincos(d8 p[2]) {
  const d8 x = p[0], q = dmul(x, x);
  d8 s = dset(0), c = dset(pktrt__math_cosine_terms[0]);
  for (int k = 0; k < 7; k++) {
    s = dmul(dadd(s, dset(pktrt__math_sine_terms[k])), q);
    c = dadd(dmul(c, q), dset(pktrt__math_cosine_terms[k + 1]));
  }
  p[0] = dadd(x, dmul(x, s)), p[1] = dadd(dset(1), dmul(c, q));
}

/* Takes points p of the square to the disk, as pktrt__map_to_disk does. */
SMALL void pktrt__vec_disk(d8 p[2]) {
  const d8 one = dset(1), a = dsub(dadd(p[0], p[0]), one), b = dsub(dadd(p[1], p[1]), one);
  const m8 wide = dlt(dabs(b), dabs(a));
  const d8 along = dsel(wide, a, b), size = dmax(dabs(along), dset(PKTRT__DISK_LEAST));
  p[0] = dmul(ddiv(dsel(wide, b, a), size), dset(PKTRT__PI / 4));
  pktrt__vec_sincos(p);
  const d8 s = dmul(size, p[0]), c = dmul(along, p[1]);
  p[0] = dsel(wide, c, s), p[1] = dsel(wide, s, c);
}

/* Turns vectors p as z is turned to the unit vectors n, as pktrt__map_along does. */
SMALL void pktrt__vec_along(const d8 n[3], d8 p[3]) {
  const d8 one = dset(1), minus = dset(-1), sign = dsel(dlt(n[2], dset(0)), minus, one);
  const d8 a = ddiv(minus, dadd(sign, n[2])), c = dmul(dmul(n[0], n[1]), a), w = dmul(sign, n[0]);
  const d8 t[3] = {dadd(one, dmul(dmul(w, n[0]), a)), dmul(sign, c), dmul(minus, w)};
  const d8 b[3] = {c, dadd(sign, dmul(dmul(n[1], n[1]), a)), dmul(minus, n[1])}, x = p[0], y = p[1], z = p[2];
  ROLL_OUT for (int k = 0; k < 3; k++) p[k] = dadd(dmul(z, n[k]), dadd(dmul(x, t[k]), dmul(y, b[k])));
}

/* Samples a quad at p. Returns which of the surfaces it is near to. */
SMALL uint32_t pktrt__light_sample_quad8(const pktrt_light *l, const pktrt__light_target *t, const d8 p[2],
                                         const pktrt__surfaces *s, uint32_t i, pktrt__light_samples *g) {
  const d8 zero = dset(0);
  d8 d2 = zero, r2 = zero, height = zero, least = zero;
  ROLL_OUT for (int a = 0; a < 3; a++) {
    const d8 from = dload(s->point[a] + i), to = dsub(dset((double)l->position[a]), from);
    const d8 across = dadd(dmul(p[0], dset((double)l->edge[0][a])), dmul(p[1], dset((double)l->edge[1][a])));
    const d8 middle = dsub(from, dset(t->at[a])), at = dadd(dadd(from, to), across), way = dsub(at, from);
    height = dadd(height, dmul(to, dset(t->facing[a]))), least = dadd(least, dabs(from));
    d2 = dadd(d2, dmul(middle, middle)), r2 = dadd(r2, dmul(way, way));
    dstore(g->at[a] + i, at);
  }
  height = dsub(zero, height), least = dmul(dset(16 * PKTRT__ERROR_PLANE), least);
  const d8 spread = ddiv(dmul(dset(t->area), height), dmul(r2, dsqrt(r2)));
  const m8 before = dlt(least, height);
  dstore(g->factor + i, dsel(before, dmul(spread, dset(t->strength)), zero));
  return mbits(before) & mbits(dlt(d2, dset(t->near2)));
}

/* Samples a sphere at p. Returns which of the surfaces are not outside it. */
SMALL uint32_t pktrt__light_sample_sphere8(const pktrt_light *l, const pktrt__light_target *t, d8 p[3],
                                           const pktrt__surfaces *s, uint32_t i, pktrt__light_samples *g) {
  const d8 one = dset(1), zero = dset(0), r2 = dset((double)l->radius * (double)l->radius);
  d8 axis[3], d2 = zero;
  ROLL_OUT for (int a = 0; a < 3; a++) {
    axis[a] = dsub(dset((double)l->position[a]), dload(s->point[a] + i));
    d2 = dadd(d2, dmul(axis[a], axis[a]));
  }
  const d8 distance = dsqrt(d2), s2 = ddiv(r2, d2), rise = ddiv(s2, dadd(one, dsqrt(dsub(one, s2))));
  ROLL_OUT for (int a = 0; a < 3; a++) axis[a] = ddiv(axis[a], distance);
  pktrt__vec_disk(p);
  const d8 down = dmul(dadd(dmul(p[0], p[0]), dmul(p[1], p[1])), rise), cosine = dsub(one, down);
  const d8 more = dadd(one, cosine), sine = dsqrt(dmul(rise, more));
  const d8 half = dsqrt(dmax(zero, dsub(r2, dmul(d2, dmul(down, more)))));
  const d8 depth = dsub(dmul(distance, cosine), half);
  p[0] = dmul(sine, p[0]), p[1] = dmul(sine, p[1]), p[2] = cosine;
  pktrt__vec_along(axis, p);
  ROLL_OUT for (int a = 0; a < 3; a++) dstore(g->at[a] + i, dadd(dload(s->point[a] + i), dmul(depth, p[a])));
  dstore(g->factor + i, dmul(dmul(dset(2 * PKTRT__PI), rise), dset(t->strength)));
  return ~mbits(dlt(s2, one));
}

/* Samples an environment that has no table at p. */
SMALL void pktrt__light_sample_sky8(const pktrt__light_target *t, d8 p[3], const pktrt__surfaces *s, uint32_t i,
                                    pktrt__light_samples *g) {
  const d8 one = dset(1), zero = dset(0), high = dsqrt(dsub(one, p[0])), wide = dsqrt(p[0]);
  d8 n[3];
  ROLL_OUT for (int a = 0; a < 3; a++) n[a] = dfrom(vload(s->ns[a] + i));
  const d8 quarters = dsub(dmul(p[1], dset(4)), dset(2));
  p[0] = dmul(dsub(dabs(quarters), one), dset(PKTRT__PI / 4));
  pktrt__vec_sincos(p);
  const d8 twice = dadd(p[0], p[0]), aside = dmul(wide, dsub(one, dmul(twice, p[0])));
  p[0] = dmul(wide, dmul(twice, p[1])), p[1] = dsel(dlt(quarters, zero), aside, dsub(zero, aside)), p[2] = high;
  pktrt__vec_along(n, p);
  ROLL_OUT for (int a = 0; a < 3; a++) dstore(g->at[a] + i, p[a]);
  const d8 density = ddiv(dmax(zero, pktrt__vec_ddot(p, n)), dset(PKTRT__PI));
  dstore(g->factor + i, dsel(dlt(zero, density), dmul(ddiv(one, density), dset(t->strength)), zero));
}

SMALL bool pktrt__light_sample_all(const pktrt_light *l, const pktrt__light_target *t, const float *u, const float *v,
                                   const pktrt__surfaces *s, pktrt__light_samples *g) {
  uint32_t any = 0;
  for (uint32_t i = 0; i < s->count; i += 8) {
    d8 p[3];
    uint32_t rest = pktrt__lanes_first(s->count - i);
    p[0] = dfrom(vload(u + i)), p[1] = dfrom(vload(v + i));
    if (l->kind == PKTRT_LIGHT_QUAD) rest &= pktrt__light_sample_quad8(l, t, p, s, i, g);
    else if (l->kind == PKTRT_LIGHT_SPHERE) rest &= pktrt__light_sample_sphere8(l, t, p, s, i, g);
    else pktrt__light_sample_sky8(t, p, s, i, g), rest = 0;
    any |= rest;
    for (; rest; rest &= rest - 1) g->factor[i + pktrt__lowest_bit(rest)] = -1;
  }
  return any != 0;
}
#endif

/* Clips the intervals [from, to] of lines to what lies between two planes. */
STEP void pktrt__glass_clip(float lo, float hi, vf rd, vf shift, vf *from, vf *to) {
  const vf t0 = ffms(fset(lo), rd, shift), t1 = ffms(fset(hi), rd, shift);
  *from = fmax_(*from, fmin_(t0, t1)), *to = fmin_(*to, fmax_(t0, t1));
}

/* Returns the rays in `lanes`, of a wide vector from i on, that meet an innermost box of glass. */
static uint32_t pktrt__glass_find_rays(const pktrt__glass_boxes *glass, const pktrt__batch *b, uint32_t i,
                                       uint32_t lanes) {
  vf rd[3], shift[3];
  uint32_t found = 0;
  for (int a = 0; a < 3; a++) {
    const vf d = fload(b->d[a] + i);
    rd[a] = fdiv(fset(1), fcopysign(fmax_(fabs_(d), fset(glass->least)), d));
    shift[a] = fmul(fload(b->o[a] + i), rd[a]);
  }
  for (const pktrt__glass_box *box = glass->boxes, *last = box + box->next; box < last && lanes;) {
    vf from = fset(0), to = fload(b->tmax + i);
    ROLL_OUT for (int a = 0; a < 3; a++) pktrt__glass_clip(box->lo[a], box->hi[a], rd[a], shift[a], &from, &to);
    const uint32_t met = lanes & ~fbits(flt(to, from)), next = box->next, ends = next == 1 ? met : 0;
    found |= ends, lanes &= ~ends;
    box += met ? 1 : next;
  }
  return found;
}

/* Writes the visibility of n shadow rays, 0 or 1, and lists those of the occluded that may go on through glass. */
static uint32_t pktrt__light_visibility(const pktrt__glass_boxes *glass, const pktrt__batch *b,
                                        float (*seen)[PKTRT__ROW], uint32_t n, uint32_t *lane) {
  uint32_t listed = 0;
  for (uint32_t i = 0; i < n; i += FW) {
    uint32_t stopped = pktrt__lanes_first(n - i) & pktrt__lanes_occupied(b->slot + i);
    if (n - i > 8 && FW > 8) stopped |= (pktrt__lanes_first(n - i - 8) & pktrt__lanes_occupied(b->slot + i + 8)) << 8;
    uint32_t met = glass->boxes && stopped ? pktrt__glass_find_rays(glass, b, i, stopped) : 0;
    for (int a = 0; a < 3; a++) fstore(seen[a] + i, fsel(ffrom(stopped), fset(0), fset(1)));
    for (; met; met &= met - 1) lane[listed++] = i + pktrt__lowest_bit(met);
  }
  return listed;
}

/* Adds the light of n shadow rays to surfaces: of eight surfaces in a row at once, else singly: some may share one. */
static void pktrt__light_add(pktrt__surfaces *s, const uint32_t *surface, float (*arriving)[PKTRT__ROW],
                             float (*seen)[PKTRT__ROW], uint32_t n) {
  for (uint32_t i = 0, next; i < n; i = next) {
    const uint32_t k = surface[i];
    uint32_t apart = 0; /* WHY: all are compared, for compilers vectorise that */
    next = i + 8;
    for (uint32_t j = 1; next <= n && j < 8; j++) apart |= surface[i + j] ^ (k + j);
    if (next <= n && !apart) {
      ROLL_OUT for (int a = 0; a < 3; a++) {
        const v8 part = vmul(vload(arriving[a] + i), vload(seen[a] + i));
        vstore(s->radiance[a] + k, vadd(vload(s->radiance[a] + k), part));
      }
    } else {
      for (uint32_t j = i; j < next && j < n; j++)
        for (int a = 0; a < 3; a++) s->radiance[a][surface[j]] += arriving[a][j] * seen[a][j];
    }
  }
}

#if PKTRT__WITH_PAPER
/* Appends rays from surfaces i to i + 7, those worth following, to the n of a wave. Returns how many it has then. */
PKTRT__NOINLINE uint32_t pktrt__spawn_rays8(const pktrt__spawn_request *g, const pktrt__wave *w,
                                            const pktrt__surfaces *s, uint32_t i, uint32_t lanes, pktrt__wave *to,
                                            uint32_t n) {
  const uint32_t at = s->first + i;
  uint32_t medium[8], key[8];
  v8 weight[3], o[3], d[3];
  ROLL_OUT for (int a = 0; a < 3; a++) {
    weight[a] = vload((g->refraction ? s->transmitted[a] : s->reflected[a]) + i);
    d[a] = vload((g->refraction ? s->refracted[a] : s->mirror[a]) + i);
    o[a] = vload(s->start[a] + i);
  }
  const v8 largest = vmax(weight[0], vmax(weight[1], weight[2]));
  const v8 importance = vmul(vload(w->importance + at), largest);
  lanes &= mbits(vlt(vset(0), largest)) & ~mbits(vlt(importance, vset(g->threshold)));
  if (!lanes) return n;
  if (g->refraction) pktrt__surface_start(s, i, -1, o);
  pktrt__spawn_inherit(g, w, s, i, lanes, medium, key);
  const c8 chosen = vchoose(lanes);
  ROLL_OUT for (int a = 0; a < 3; a++) {
    vcompress(to->rays.o[a] + n, chosen, o[a]);
    vcompress(to->rays.d[a] + n, chosen, d[a]);
    vcompress(to->weight[a] + n, chosen, weight[a]);
  }
  vcompress_from(to->rays.time + n, chosen, w->rays.time + at);
  vcompress(to->importance + n, chosen, importance);
  vcompress_from(to->medium + n, chosen, medium);
  vcompress_from(to->key + n, chosen, key);
  vcompress_from(to->parent + n, chosen, s->ray + i);
  vcompress_from(to->material + n, chosen, s->material + i);
  vcompress_from(to->root + n, chosen, w->root + at);
  if (PKTRT__GLOSS && g->lobes)
    vcompress_from(to->density + n, chosen, s->shared + i), vcompress_from(to->sky + n, chosen, s->sky + i);
  return n + pktrt__popcount8(lanes);
}

static uint32_t pktrt__spawn_rays(const pktrt__spawn_request *g, const pktrt__wave *w, const pktrt__surfaces *s,
                                  pktrt__wave *to, uint32_t n) {
  for (uint32_t i = 0; i < s->count; i += 8) {
    const uint32_t glass = s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8], none = s->kind[PKTRT_SPECULAR_NONE][i / 8];
    const uint32_t lanes =
        pktrt__lanes_first(s->count - i) & (g->refraction ? glass : ~none) & ~(uint32_t)s->shaded[i / 8];
    if (lanes) n = pktrt__spawn_rays8(g, w, s, i, lanes, to, n);
  }
  return n;
}
#define PKTRT__SPAWN_RAYS pktrt__spawn_rays
#else
#define PKTRT__SPAWN_RAYS pktrt__spawn_rays_avx2
#endif

#endif /* PKTRT_NO_RENDER */

/* >>fit ------------------------------------------------------------------------------------------------------------ */

#if PKTRT__WITH_FIT

static uint32_t pktrt__fit_lanes_with_area(const float *v) {
  d8 a[3], b[3];
  UNROLL for (int i = 0; i < 3; i++) {
    const d8 from = dfrom(vload(v + 8 * i));
    a[i] = dsub(dfrom(vload(v + 24 + 8 * i)), from), b[i] = dsub(dfrom(vload(v + 48 + 8 * i)), from);
  }
  const d8 x = dsub(dmul(a[1], b[2]), dmul(a[2], b[1])), y = dsub(dmul(a[2], b[0]), dmul(a[0], b[2]));
  const d8 z = dsub(dmul(a[0], b[1]), dmul(a[1], b[0]));
  return mbits(dlt(dset(0), dmax(dabs(x), dmax(dabs(y), dabs(z)))));
}

/* Computes the planes of a node's children at a key: leaf blocks' from their vertices, nodes' from their children. Where all
   is hidden they are those of an empty child. */
static void pktrt__fit_children(const pktrt__bvh *bvh, const uint32_t *child, uint32_t key, float *plane) {
  for (int c = 0; c < 8; c++) {
    const bool leaf = (child[c] & PKTRT__LEAF) != 0;
    if (child[c] == PKTRT__EMPTY || (leaf && bvh->split)) continue;
    const float *p = leaf ? pktrt__block_vertices(pktrt__bvh_block(bvh, child[c] & ~PKTRT__LEAF), key)
                          : pktrt__node_planes(pktrt__bvh_node(bvh, child[c]), key);
    if (PKTRT__UNLIKELY(leaf && p[0] > PKTRT__FAR)) {
      for (int i = 0; i < 6; i++) plane[8 * i + c] = i & 1 ? -PKTRT__FAR : PKTRT__FAR;
      continue;
    }
    for (int a = 0; a < 3; a++) {
      const float *q = leaf ? p + 8 * a : p + 16 * a;
      const v8 x = vload(q), y = leaf ? vload(q + 24) : vload(q + 8), z = leaf ? vload(q + 48) : y;
      plane[16 * a + c] = vhmin(leaf ? vmin(vmin(x, y), z) : x);
      plane[16 * a + 8 + c] = vhmax(leaf ? vmax(vmax(x, y), z) : y);
    }
  }
}

/* Refits nodes and returns the sum of their children's areas. Children follow parents, so backwards is bottom-up. */
static double pktrt__fit_nodes(const pktrt__bvh *bvh, uint32_t first, uint32_t count) {
  double sum = 0.0, area[8];
  for (uint32_t n = first + count; n-- > first;) {
    pktrt__node *node = pktrt__bvh_node(bvh, n);
    const uint32_t *child = node->child;
    for (uint32_t k = 0; k < bvh->key_count; k++) {
      float *p = pktrt__node_planes(node, k);
      pktrt__fit_children(bvh, child, k, p);
      const d8 x = dsub(dfrom(vload(p + 8)), dfrom(vload(p))), y = dsub(dfrom(vload(p + 24)), dfrom(vload(p + 16)));
      const d8 z = dsub(dfrom(vload(p + 40)), dfrom(vload(p + 32)));
      dstore(area, dmul(dset(2.0), dadd(dadd(dmul(x, y), dmul(y, z)), dmul(z, x))));
      for (int c = 0; c < 8; c++) sum += p[c] > p[8 + c] ? 0.0 : area[c];
    }
    pktrt__bvh_order_children(bvh, node);
  }
  return sum;
}

#ifndef PKTRT_NO_RENDER
static const pktrt__fit_table pktrt__fit_kernels = {pktrt__fit_lanes_with_area, pktrt__fit_nodes,
                                                    pktrt__light_sample_all};
#else
static const pktrt__fit_table pktrt__fit_kernels = {pktrt__fit_lanes_with_area, pktrt__fit_nodes};
#endif
#endif

#ifndef PKTRT__NO_TOP
/* >>instances: rays at the top level, and in the models there --------------------------------------------------------

   The top level is a tree of a scene of boxes, in whose leaf blocks a triangle's first two corners are the corners of an
   instance's box. Rays have been through all other trees before, so that a hit in an instance is never replaced by one of
   these. Within a model they are traced as elsewhere, in spare lanes of the batch. */

/* What box tests need of a ray, wherever it is kept: `step` is the distance from one axis to the next in rd, cn and cf. */
typedef struct pktrt__place_slabs {
  const float *rd, *cn, *cf;
  size_t step;
  float wn, wf, tb;
} pktrt__place_slabs;

/* Returns those boxes of a block of instances that a ray may hit at its time, and finds their entry depths. */
SHARED uint32_t pktrt__place_test_boxes(const pktrt__bvh_segment *seg, uint32_t index, const pktrt__place_slabs *q,
                                        float *entry, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  const float *k0 = pktrt__segment_vertices(seg, block, 0, moving),
              *k1 = pktrt__segment_vertices(seg, block, 1, moving);
  const v8 t = vset(q->tb);
  v8 n = vset(q->wn), f = vset(q->wf);
  UNROLL for (uint32_t a = 0; a < 3; a++, k0 += 8, k1 += 8) {
    const v8 lo0 = vload(k0), hi0 = vload(k0 + 24), r = vset(q->rd[q->step * a]);
    const v8 lo = vmul(moving ? vfma(t, vsub(vload(k1), lo0), lo0) : lo0, r),
             hi = vmul(moving ? vfma(t, vsub(vload(k1 + 24), hi0), hi0) : hi0, r);
    n = vmax(vsub(vmin(lo, hi), vset(q->cn[q->step * a])), n),
    f = vmin(vsub(vmax(lo, hi), vset(q->cf[q->step * a])), f);
  }
  vstore(entry, n);
  return mbits(vle(n, f)) & pktrt__lanes_occupied(seg->bvhs[seg->bvh].block_triangles + (size_t)index * 8);
}

#if PKTRT__WITH_V8_REGISTERS
/* How an instance lies: what pktrt__place has, columns twice. */
typedef struct pktrt__place_frame {
  d8 column[3], diagonal, shift;
} pktrt__place_frame;
OP pktrt__place_frame pktrt__place_load(const pktrt__place *p) {
  pktrt__place_frame f;
  UNROLL for (int i = 0; i < 3; i++) f.column[i] = dload_twice(p->inverse[i]);
  f.diagonal = dload_twice(p->inverse[3]), f.shift = dload_low(p->shift);
  return f;
}
/* Computes cross products of both halves. */
OP d8 pktrt__place_cross(d8 a, d8 b) {
  return dsub(dmul(drotate(a, 1), drotate(b, 2)), dmul(drotate(a, 2), drotate(b, 1)));
}
/* Does what pktrt__place_mix and _invert do, but for the diagonal: rows of the matrix, two at a time, each with its part of the
   shift, are mixed; the adjugate's columns are their cross products. */
OP pktrt__place_frame pktrt__place_load_between(const float *k0, const float *k1, float ta, float tb) {
  const d8 a = dset((double)ta), b = dset((double)tb);
  const d8 xy = dadd(dmul(a, dfrom(vload(k0))), dmul(b, dfrom(vload(k1))));
  const d8 yz = dadd(dmul(a, dfrom(vload(k0 + 4))), dmul(b, dfrom(vload(k1 + 4))));
  const d8 first = pktrt__place_cross(yz, dhalves(yz, xy, 2)), last = pktrt__place_cross(xy, yz);
  const d8 product = dmul(xy, first), low = dhalves(product, product, 0);
  const d8 r = ddiv(dset(1), dadd(dadd(dspread(low, 0), dspread(low, 1)), dspread(low, 2)));
  double row[16], shift[4];
  pktrt__place_frame f;
  f.column[0] = dmul(dhalves(first, first, 0), r), f.column[1] = dmul(dhalves(first, first, 1), r);
  f.column[2] = f.diagonal = dmul(dhalves(last, last, 0), r);
  dstore(row, xy), dstore(row + 8, yz);
  shift[0] = row[3], shift[1] = row[7], shift[2] = row[15], shift[3] = 0;
  f.shift = dload_low(shift);
  return f;
}
#endif

/* Computes a ray in the frame of an instance, which ends at tmax; returns whether it has a direction there. */
OP bool pktrt__place_ray_within(const pktrt__instance *in, const pktrt_ray *ray, float tmin, float tmax,
                                pktrt_ray *within) {
  pktrt__place moving;
  within->time = ray->time, within->tmin = tmin, within->tmax = tmax;
#if PKTRT__WITH_V8_REGISTERS /* origin and direction side by side, in one store */
  const v8 from = vload((const float *)(const void *)ray);
  pktrt__place_frame f;
  if (pktrt__has_motion(in->key_count) && !in->rest.straight) {
    float ta, tb;
    const float *key = in->keys + 12 * (size_t)pktrt__time_segment(ray->time, in->key_count, &ta, &tb);
    f = pktrt__place_load_between(key, key + 12, ta, tb);
  } else {
    f = pktrt__place_load(pktrt__place_at(in, ray->time, &moving));
  }
  const d8 x = dsub(dfrom(from), f.shift);
  d8 to = dmul(f.diagonal, x);
  if (!in->rest.straight)
    to = dadd(dadd(dmul(f.column[0], dspread(x, 0)), dmul(f.column[1], dspread(x, 1))),
              dmul(f.column[2], dspread(x, 2)));
  const d8 size = dabs(to);
  vstore((float *)(void *)within, vsel(mfrom(0x88), vsel(mfrom(0x80), vset(tmax), vset(tmin)), dto(to)));
  return (mbits(dlt(size, dset(PKTRT__PLACE_LEAST))) & 0x70) != 0x70 &&
         !(mbits(dlt(dset(1 / PKTRT__PLACE_LEAST), size)) & 0x70);
#else
  pktrt__place_ray(pktrt__place_at(in, ray->time, &moving), ray->origin, ray->direction, 1, within->origin,
                   within->direction, 1);
  return true; /* one that has none is refused when it is set up */
#endif
}

/* Traces a single ray through an instance; tells whether it hits, or hits nearer. */
SMALL bool pktrt__place_trace_single(const pktrt_scene *scene, pktrt__single *q, uint32_t index,
                                     const pktrt__variant *what) {
  const pktrt__instance *in = &scene->instances[index];
  const pktrt_ray *from = q->ray;
  pktrt_ray ray;
  pktrt__single within;
  const bool earlier = q->after != PKTRT_NONE && q->after < in->first_id;
  const float tmin = earlier ? nextafterf(from->tmin, -INFINITY) : from->tmin;
  const float tmax = what->occlusion ? from->tmax : pktrt__place_tmax(q->slot, q->wf, q->dk, from->tmax);
  if (!pktrt__place_ray_within(in, from, tmin, tmax, &ray)) return false;
  if (!pktrt__single_setup(in->model, &ray, &within)) return false;
  if (q->after != PKTRT_NONE && q->after >= in->first_id) within.after = q->after - in->first_id;
  const pktrt__bvh *bvh = in->model->bvhs;
  bool found;
  if (in->model->single_tree && !COUNTED(*what)) /* as most models are */
    found =
        (bvh->mask & what->mask) && pktrt__single_traverse(&bvh->rest, &within, 0, pktrt__variant_moving(*what, false));
  else found = pktrt__drive_single(in->model, &within, what);
  if (!found || what->occlusion) return found;
  pktrt__place_hit hit = {0, 0, index + 1, in->first_id + within.id, within.slot, within.bvh};
  pktrt__place_hit_bounds(&hit, within.sf, within.wf, within.dk, q->dk, q->tiny);
  if (q->slot != PKTRT_NONE && !(hit.hi < q->sf) && (q->wf < hit.lo || !pktrt__place_is_nearer(scene, q, &hit)))
    return false;
  q->sf = hit.lo, q->wf = hit.hi, q->id = hit.id, q->slot = hit.slot, q->bvh = hit.bvh, q->place = hit.place;
  memcpy(q->there, &ray, sizeof q->there);
  return true;
}

/* Traces a single ray through the instances above a tree of the top level, nearest child first. */
OP bool pktrt__place_single_in(const pktrt_scene *scene, const pktrt__bvh_segment *seg, pktrt__single *q,
                               const pktrt__variant is) {
  struct {
    uint32_t ref;
    float dist;
  } stack[PKTRT__STACK + 8], *top = stack, swap;
  PKTRT__ALIGN64 float dist[8];
  const pktrt__single_slabs slabs = pktrt__single_slabs_of(q, is.moving);
  bool hit = false;
  for (uint32_t ref = 0;; ref = top->ref) {
    uint32_t bits;
    if (ref & PKTRT__LEAF) {
      const uint32_t *instance = seg->bvhs[seg->bvh].block_triangles + (size_t)(ref & ~PKTRT__LEAF) * 8;
      const pktrt__place_slabs box = {q->rd, q->cn, q->cf, 1, q->wn, q->wf, q->tb};
      bits = pktrt__place_test_boxes(seg, ref & ~PKTRT__LEAF, &box, dist, is.moving);
      while (bits) {
        const uint32_t c = pktrt__place_nearest(bits, dist);
        bits &= ~(1u << c);
        if (dist[c] > q->wf) continue;
        if (pktrt__place_is_group(scene, seg))
          hit |= pktrt__drive_single_in(scene, q, scene->direct_count + instance[c], is);
        else if (PKTRT__INSTANCES && (scene->instances[instance[c]].seen & is.mask))
          hit |= pktrt__place_trace_single(scene, q, instance[c], &is);
        if (is.occlusion && hit) return true;
      }
    } else {
      const uint32_t *child;
      v8 entry;
      bits = pktrt__single_open_node(&slabs, seg, ref, q->wf, &child, &entry, is);
      vstore(dist, entry);
      for (uint32_t n = 0; bits; bits &= bits - 1, n++) { /* the nearest on top */
        top->ref = child[pktrt__lowest_bit(bits)], top->dist = dist[pktrt__lowest_bit(bits)];
        if (n && top[-1].dist < top->dist) swap = top[-1], top[-1] = *top, *top = swap;
        top++;
      }
    }
    do {
      if (top == stack) return hit;
      top--;
    } while (top->dist > q->wf);
  }
}
SMALL bool pktrt__place_single(const pktrt_scene *scene, pktrt__single *q, const pktrt__variant *what) {
  const pktrt__variant is = *what;
  bool hit = false;
  for (int which = 0; which < 2; which++) {
    const pktrt_scene *top = which ? scene->boxes : scene->groups;
    for (uint32_t i = 0; top && i < top->bvh_count && !(is.occlusion && hit); i++) {
      const bool moving = !PKTRT__WITH_V8_REGISTERS || pktrt__has_motion(top->bvhs[i].key_count);
      const uint32_t segment = pktrt__time_segment(q->ray->time, top->bvhs[i].key_count, &q->ta, &q->tb);
      const pktrt__bvh_segment seg = pktrt__bvh_segment_of(top->bvhs, i, segment);
      hit |= moving ? pktrt__place_single_in(scene, &seg, q, pktrt__variant_moving(is, true))
                    : pktrt__place_single_in(scene, &seg, q, pktrt__variant_moving(is, false));
    }
  }
  return hit;
}

#if PKTRT__WITH_FEW_INSTANCES
/* Traces the rays in mask of a list through all instances, one by one; for occlusion marks those that are hit. */
SMALL void pktrt__place_stream(const pktrt__query *call, const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list,
                               uint64_t mask, const pktrt__variant *what) {
  (void)call;
  for (; mask; mask &= mask - 1) {
    const uint32_t r = list[pktrt__lowest_bit(mask)];
    pktrt_ray ray;
    pktrt__single q;
    pktrt__single_from_batch(b, r, &ray, &q);
    if (!pktrt__place_single(scene, &q, what)) continue;
    pktrt__single_to_batch(b, r, &q);
    if (what->occlusion) b->slot[r] = 0;
  }
}
#else
#if PKTRT__WITH_V8_REGISTERS
/* Computes the matrices of an instance between two keys, at eight times, and what points are shifted by. */
SMALL void pktrt__place_matrix8(const float *k0, const float *k1, v8 time, d8 m[3][3], d8 shift[3]) {
  const v8 tb = vmin(vmax(time, vset(0)), vset(1));
  const d8 b = dfrom(tb), a = dfrom(vsub(vset(1), tb));
  UNROLL for (int i = 0; i < 3; i++) {
    UNROLL for (int j = 0; j < 3; j++) {
      m[i][j] = dadd(dmul(a, dset((double)k0[4 * i + j])), dmul(b, dset((double)k1[4 * i + j])));
    }
    shift[i] = dadd(dmul(a, dset((double)k0[4 * i + 3])), dmul(b, dset((double)k1[4 * i + 3])));
  }
}
/* Inverts them. */
OP void pktrt__place_between8(const float *k0, const float *k1, v8 time, d8 inverse[3][3], d8 shift[3]) {
  d8 m[3][3], x[3][3];
  pktrt__place_matrix8(k0, k1, time, m, shift);
  UNROLL for (int i = 0; i < 3; i++) {
    const d8 *u = m[(i + 1) % 3], *v = m[(i + 2) % 3];
    UNROLL for (int j = 0; j < 3; j++) {
      x[j][i] = dsub(dmul(u[(j + 1) % 3], v[(j + 2) % 3]), dmul(u[(j + 2) % 3], v[(j + 1) % 3]));
    }
  }
  const d8 det = dadd(dadd(dmul(m[0][0], x[0][0]), dmul(m[0][1], x[1][0])), dmul(m[0][2], x[2][0]));
  const d8 r = ddiv(dset(1), det);
  UNROLL for (int i = 0; i < 3; i++) { UNROLL for (int j = 0; j < 3; j++) inverse[i][j] = dmul(x[i][j], r); }
}

/* Does for eight rays what pktrt__place_ray does, given how the instance lies at their times. */
OP void pktrt__place_ray8(d8 m[3][3], const d8 shift[3], bool straight, pktrt__batch *b, uint32_t i) {
  d8 x[3], d[3], at[3], way[3];
  UNROLL for (int a = 0; a < 3; a++) {
    x[a] = dsub(dfrom(vload(b->o[a] + i)), shift[a]), d[a] = dfrom(vload(b->d[a] + i));
    at[a] = dmul(m[a][a], x[a]), way[a] = dmul(m[a][a], d[a]);
  }
  if (!straight) {
    UNROLL for (int a = 0; a < 3; a++) {
      at[a] = dadd(dadd(dmul(m[a][0], x[0]), dmul(m[a][1], x[1])), dmul(m[a][2], x[2]));
      way[a] = dadd(dadd(dmul(m[a][0], d[0]), dmul(m[a][1], d[1])), dmul(m[a][2], d[2]));
    }
  }
  const d8 most = pktrt__vec_dmax_abs3(way[0], way[1], way[2]);
  const m8 out = mor(dlt(most, dset(PKTRT__PLACE_LEAST)), dlt(dset(1 / PKTRT__PLACE_LEAST), most));
  UNROLL for (int a = 0; a < 3; a++) {
    vstore(b->o[a] + i, dto(at[a]));
    vstore(b->d[a] + i, vsel(out, vset(0), dto(way[a])));
  }
}
/* Does so for rays [begin, end) of a batch, all at rest or between the same two keys. */
PKTRT__NOINLINE void pktrt__place_rays8(const pktrt__instance *in, pktrt__batch *b, uint32_t begin, uint32_t end) {
  const bool straight = in->rest.straight;
  d8 m[3][3], shift[3];
  if (pktrt__has_motion(in->key_count)) {
    for (uint32_t i = begin; i < end; i += 8) {
      pktrt__place_between8(in->keys, in->keys + 12, vload(b->time + i), m, shift);
      pktrt__place_ray8(m, shift, straight, b, i);
    }
    return;
  }
  UNROLL for (int a = 0; a < 3; a++) {
    UNROLL for (int j = 0; j < 3; j++) m[a][j] = dset(in->rest.inverse[j][a]);
    shift[a] = dset(in->rest.shift[a]);
  }
  for (uint32_t i = begin; i < end; i += 8) pktrt__place_ray8(m, shift, straight, b, i);
}

/* Loads how instances at rest lie, for the lanes in `some` of rays i to i + 7: matrices, inverses and shifts. */
OP void pktrt__place_load8(const pktrt_scene *scene, const pktrt__batch *b, uint32_t i, uint32_t some, d8 m[3][3],
                           d8 inverse[3][3], d8 shift[3]) {
  double lanes[7][3][8];
  const uint32_t place = b->place[i + pktrt__lowest_bit(some)];
  if (!(some & ~veq_u32(b->place + i, place))) { /* one */
    const pktrt__place *p = &scene->instances[place - 1].rest;
    UNROLL for (int a = 0; a < 3; a++) {
      UNROLL for (int j = 0; j < 3; j++) m[a][j] = dset(p->a[a][j]), inverse[a][j] = dset(p->inverse[j][a]);
      shift[a] = dset(p->shift[a]);
    }
    return;
  }
  memset(lanes, 0, sizeof lanes);
  for (uint32_t rest = some; rest; rest &= rest - 1) {
    const uint32_t l = pktrt__lowest_bit(rest);
    const pktrt__place *p = &scene->instances[b->place[i + l] - 1].rest;
    UNROLL for (int a = 0; a < 3; a++) {
      UNROLL for (int j = 0; j < 3; j++) lanes[a][j][l] = p->a[a][j], lanes[3 + a][j][l] = p->inverse[j][a];
      lanes[6][a][l] = p->shift[a];
    }
  }
  UNROLL for (int a = 0; a < 3; a++) {
    UNROLL for (int j = 0; j < 3; j++) m[a][j] = dload(lanes[a][j]), inverse[a][j] = dload(lanes[3 + a][j]);
    shift[a] = dload(lanes[6][a]);
  }
}
/* Resolves those of rays i to i + 7 in `hits`, as pktrt__place_resolve does, in spare lanes: of one moving instance, or of
   instances of one model at rest, all with diagonals or none. */
PKTRT__NOINLINE void pktrt__place_resolve8(const pktrt_scene *scene, pktrt__batch *b, uint32_t i, uint32_t hits) {
  const pktrt__instance *in = &scene->instances[b->place[i + pktrt__lowest_bit(hits)] - 1];
  const uint32_t at = b->spare;
  const m8 some = mfrom(hits);
  pktrt__place_turn8 turn;
  d8 inverse[3][3], shift[3];
  pktrt__batch_copy_rays(b, at, b, i, 8);
  memcpy(b->slot + at, b->slot + i, 8 * sizeof *b->slot), memcpy(b->bvh + at, b->bvh + i, 8 * sizeof *b->bvh);
  turn.straight = in->rest.straight;
  if (pktrt__has_motion(in->key_count)) {
    pktrt__place_matrix8(in->keys, in->keys + 12, vload(b->time + i), turn.m, shift);
    pktrt__place_rays8(in, b, at, at + 8);
  } else {
    pktrt__place_load8(scene, b, i, hits, turn.m, inverse, shift);
    pktrt__place_ray8(inverse, shift, turn.straight, b, at);
  }
  const uint32_t left = pktrt__resolve_hits(in->model, b, at, hits, &turn);
  vstore_masked(b->t + i, some, vload(b->t + at));
  vstore_masked(b->as.hit.u + i, some, vload(b->as.hit.u + at));
  vstore_masked(b->as.hit.v + i, some, vload(b->as.hit.v + at));
  for (int a = 0; a < 3; a++) vstore_masked(b->as.hit.normal[a] + i, some, vload(b->as.hit.normal[a] + at));
  if (left) pktrt__place_resolve_hits(scene, b, i, left);
}
#endif
#if PKTRT__WITH_V8_REGISTERS
/* Does what pktrt__place_copy_rays does, for neighbours: ray i of the list is `base` + i. */
PKTRT__NOINLINE uint32_t pktrt__place_copy_row(pktrt__batch *b, uint32_t base, uint64_t mask, bool closest) {
  uint32_t n = b->spare;
  for (uint32_t r = base; mask; mask >>= 8, r += 8) {
    const uint32_t lanes = (uint32_t)mask & 0xFF;
    if (!lanes) continue;
    const c8 chosen = vchoose(lanes);
    UNROLL for (int a = 0; a < 3; a++) {
      vcompress(b->o[a] + n, chosen, vload(b->o[a] + r));
      vcompress(b->d[a] + n, chosen, vload(b->d[a] + r));
    }
    const v8 tmax = vload(b->tmax + r), nearest = vmin(vdiv(vload(b->wf + r), vabs(vload(b->dk + r))), tmax);
    const m8 unhit = mfrom(closest ? pktrt__lanes_unhit(b->slot + r) : 0xFF);
    vcompress(b->tmin + n, chosen, vload(b->tmin + r)), vcompress(b->time + n, chosen, vload(b->time + r));
    vcompress(b->tmax + n, chosen, vsel(unhit, tmax, nearest));
    n += pktrt__popcount8(lanes);
  }
  pktrt__batch_pad(b, n);
  return n - b->spare;
}
#endif
/* Moves rays [begin, end) of a batch to the frame of an instance. */
OP void pktrt__place_rays(const pktrt__instance *in, pktrt__batch *b, uint32_t begin, uint32_t end) {
#if PKTRT__WITH_V8_REGISTERS
  if (in->key_count < 3) {
    pktrt__place_rays8(in, b, begin, end);
    return;
  }
#endif
  pktrt__place_move_rays(in, b, begin, end);
}

/* Traces a few rays of a list through an instance, one by one; returns those that hit, or hit nearer. */
PKTRT__NOINLINE uint64_t pktrt__place_trace_few(const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list,
                                                uint64_t mask, uint32_t index, const pktrt__variant *what) {
  uint64_t hit = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t r = list[pktrt__lowest_bit(mask)];
    pktrt_ray ray;
    pktrt__single q; /* what instances ask of it, a third of pktrt__single_from_batch */
    for (int a = 0; a < 3; a++) ray.origin[a] = b->o[a][r], ray.direction[a] = b->d[a][r];
    ray.tmin = b->tmin[r], ray.tmax = b->tmax[r], ray.time = b->time[r];
    q.ray = &ray, q.dk = b->dk[r], q.tiny = b->tiny[r], q.axis = pktrt__axes[b->axis[r]], q.after = PKTRT_NONE;
    q.wf = b->wf[r], q.sf = b->sf[r];
    q.id = b->id[r], q.slot = b->slot[r], q.bvh = b->bvh[r], q.place = b->place[r];
    if (!pktrt__place_trace_single(scene, &q, index, what)) continue;
    hit |= mask & (0u - mask);
    if (!what->occlusion) pktrt__single_to_batch(b, r, &q);
  }
  return hit;
}

/* Traces the rays in mask of a list, all of one octant, through an instance; returns those that hit, or hit nearer. */
PKTRT__NOINLINE uint64_t pktrt__place_trace(const pktrt__query *call, const pktrt_scene *scene, pktrt__batch *b,
                                            const uint8_t *list, uint64_t mask, uint32_t index,
                                            const pktrt__variant *what) {
  const pktrt__variant is = *what;
  const pktrt_scene *model = scene->instances[index].model;
  if (!call && pktrt__popcount(mask) < PKTRT__FEW_OF_INSTANCE)
    return pktrt__place_trace_few(scene, b, list, mask, index, what);
  const uint32_t first = b->spare;
#if PKTRT__WITH_V8_REGISTERS /* lists ascend */
  const uint32_t low = pktrt__lowest_bit(mask), high = pktrt__highest_bit(mask);
  const uint32_t n = (uint32_t)(list[high] - list[low]) == high - low
                         ? pktrt__place_copy_row(b, list[low] - low, mask, !is.occlusion)
                         : pktrt__place_copy_rays(b, list, mask, !is.occlusion);
#else
  const uint32_t n = pktrt__place_copy_rays(b, list, mask, !is.occlusion);
#endif
  pktrt__place_rays(&scene->instances[index], b, first, first + n);
  uint64_t valid = 0;
  for (uint32_t i = 0; i < n; i += FW) valid |= (uint64_t)pktrt__batch_setup(model, b, first + i) << i;
  b->valid[first / 64] = valid;
#if !defined(PKTRT_NO_PAPER) && PKTRT__WITH_PAPER
  if (call) {
    pktrt__drive_paper(call, model, b, first, first + n, is.occlusion);
  } else
#endif
      if (valid) {
    uint64_t moving[PKTRT__BATCH / 64], rays[PKTRT__BATCH / 64];
    memcpy(moving, b->moving, sizeof moving); /* what was found of the scene's trees, not the model's */
    memset(rays, 0, sizeof rays), rays[first / 64] = valid;
    if (n > PKTRT__FEW_OF_PACKET) pktrt__drive_fast(model, b, first, first + n, &is);
    else pktrt__drive_octants(model, b, rays, &is); /* too few for packets */
    memcpy(b->moving, moving, sizeof moving);
  }
  (void)call;
  return pktrt__place_take(scene, index, b, list, mask, !is.occlusion);
}

/* Boxes of instances in a block, as rays enter and leave them. */
OP pktrt__box_slabs pktrt__place_load_slabs(const pktrt__bvh_segment *seg, uint32_t index, uint32_t octant,
                                            const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  const float *k0 = pktrt__segment_vertices(seg, block, 0, moving),
              *k1 = pktrt__segment_vertices(seg, block, 1, moving);
  pktrt__box_slabs s;
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    const uint32_t n = 8 * a + 24 * (octant >> a & 1), f = 8 * a + 24 * (~octant >> a & 1);
    s.near0[a] = vload(k0 + n), s.far0[a] = vload(k0 + f);
    if (moving) s.near1[a] = vsub(vload(k1 + n), s.near0[a]), s.far1[a] = vsub(vload(k1 + f), s.far0[a]);
  }
  return s;
}

/* Traces rays through an instance, or through a tree of a group. */
OP uint64_t pktrt__place_enter(const pktrt__query *call, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                               pktrt__batch *b, const uint8_t *list, uint64_t mask, uint32_t index,
                               const pktrt__variant *is) {
  if (pktrt__place_is_group(scene, seg))
    return pktrt__drive_stream_in(scene, b, list, mask, scene->direct_count + index, is);
  if (!PKTRT__INSTANCES || !(scene->instances[index].seen & is->mask)) return 0;
  return pktrt__place_trace(call, scene, b, list, mask, index, is);
}
/* Traces rays of one octant through the instances of a block, the nearest first; returns those that hit, or hit nearer.
   Rays that have hit something on the way are asked for the boxes anew. */
OP uint64_t pktrt__place_leaf(const pktrt__query *call, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                              pktrt__batch *b, const uint8_t *list, uint64_t mask, uint32_t index,
                              const pktrt__variant is) {
  static const uint32_t lanes[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  const uint32_t *instance = seg->bvhs[seg->bvh].block_triangles + (size_t)index * 8;
  uint64_t rays[8] = {0, 0, 0, 0, 0, 0, 0, 0}, hit = 0, asked = mask;
  uint32_t left = pktrt__lanes_occupied(instance);
  float nearest[8];
  for (uint32_t c; left; left &= ~(1u << c)) {
    if (asked) {
      const pktrt__box_slabs slabs =
          pktrt__place_load_slabs(seg, index, b->octant[list[pktrt__lowest_bit(asked)]], is.moving);
      a8 enter = azero();
      v8 entry, first = vset(INFINITY);
      uint64_t masks[8];
      uint32_t lane[8];
      float dist[8];
      for (uint64_t m = asked; m; m &= m - 1) {
        const uint32_t i = pktrt__lowest_bit(m);
        const m8 enters = pktrt__box_test_children(&slabs, b, list[i], is.moving, &entry);
        enter = aor(enter, enters, i), first = vmin(first, vsel(enters, entry, first));
      }
      for (c = 0; c < 8; c++) rays[c] &= ~asked;
      c = apush(enter, lanes, first, PKTRT__IN_ORDER, masks, lane, dist);
      while (c--) rays[lane[c]] |= masks[c], nearest[lane[c]] = dist[c];
      for (c = 0; c < 8; c++) left &= ~(rays[c] ? 0 : 1u << c);
      if (!left) break;
    }
    c = pktrt__place_nearest(left, nearest);
    asked = 0;
    if (is.occlusion) rays[c] &= ~hit;
    if (!rays[c]) continue;
    asked = pktrt__place_enter(call, scene, seg, b, list, rays[c], instance[c], &is);
    hit |= asked;
    if (is.occlusion) asked = 0;
  }
  return hit;
}

/* Traces the rays in mask of a list, all of one octant, through the instances above a tree of the top level. */
OP uint64_t pktrt__place_stream_template(const pktrt__query *call, const pktrt_scene *scene,
                                         const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list,
                                         uint64_t mask, uint32_t ref, const pktrt__variant is) {
  pktrt__stream_stack stack;
  uint64_t hit = 0;
  const uint32_t octant = b->octant[list[pktrt__lowest_bit(mask)]];
  stack.n = 0;
  for (;; ref = stack.refs[stack.n]) {
    if (ref & PKTRT__LEAF) {
      hit |= pktrt__place_leaf(call, scene, seg, b, list, mask, ref & ~PKTRT__LEAF, is);
    } else {
      COUNT(node_visits, 1);
      COUNT(box_tests, pktrt__bvh_child_count(pktrt__bvh_children(seg, ref, is.moving)) * pktrt__popcount(mask));
      pktrt__stream_open_node(seg, b, list, mask, ref, octant, &stack, is);
    }
    do {
      if (!stack.n) return hit;
      mask = stack.masks[--stack.n];
      if (is.occlusion) mask &= ~hit;
      else if (!(mask & (mask - 1)) && stack.dists[stack.n] > b->wf[list[pktrt__lowest_bit(mask)]]) mask = 0;
    } while (!mask);
  }
}
SMALL uint64_t pktrt__place_stream_in(const pktrt__query *call, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                                      pktrt__batch *b, const uint8_t *list, uint64_t mask, uint32_t ref,
                                      const pktrt__variant *what) {
  const pktrt__variant is = *what;
  if (PKTRT__WITH_V8_REGISTERS && !is.moving)
    return pktrt__place_stream_template(call, scene, seg, b, list, mask, ref, pktrt__variant_moving(is, false));
  return pktrt__place_stream_template(call, scene, seg, b, list, mask, ref, pktrt__variant_moving(is, true));
}
/* Does so for all trees of the top level; for occlusion marks the rays that are hit. */
SMALL void pktrt__place_stream(const pktrt__query *call, const pktrt_scene *scene, pktrt__batch *b, const uint8_t *list,
                               uint64_t mask, const pktrt__variant *what) {
  uint64_t hit = 0;
  for (int which = 0; which < 2; which++) {
    const pktrt_scene *top = which ? scene->boxes : scene->groups;
    for (uint32_t i = 0; top && i < top->bvh_count; i++) {
      const uint32_t keys = top->bvhs[i].key_count;
      const pktrt__variant is = pktrt__variant_moving(*what, pktrt__has_motion(keys));
      for (uint64_t m = mask; m; m &= m - 1) pktrt__batch_time_weights(b, list[pktrt__lowest_bit(m)], 1, keys);
      for (uint64_t rest = is.occlusion ? mask & ~hit : mask; rest;) {
        const uint32_t segment = b->segment[list[pktrt__lowest_bit(rest)]];
        const uint64_t same = keys > 2 ? pktrt__drive_rays_of_segment(b, list, rest, segment) : rest;
        const pktrt__bvh_segment seg = pktrt__bvh_segment_of(top->bvhs, i, segment);
        hit |= pktrt__place_stream_in(call, scene, &seg, b, list, same, 0, &is);
        rest &= ~same;
      }
    }
  }
  for (uint64_t m = what->occlusion ? hit : 0; m; m &= m - 1) b->slot[list[pktrt__lowest_bit(m)]] = 0;
}

#if PKTRT__WITH_TOP_FRUSTA
/* Traces a packet through the instances of a block, the nearest first; returns the rays that hit, or hit nearer. */
OP uint64_t pktrt__place_frustum_leaf(pktrt__frustum *f, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                                      pktrt__batch *b, uint32_t index, uint64_t mask, const pktrt__variant *is) {
  const uint32_t *instance = seg->bvhs[seg->bvh].block_triangles + (size_t)index * 8;
  const pktrt__block *block = pktrt__segment_block(seg, index, true);
  PKTRT__ALIGN64 float planes[2][48], nearest[8]; /* as a node has them */
  uint64_t hit = 0;
  uint32_t whole;
  v8 entry;
  for (uint32_t i = 0; i < 12; i++) {
    const float *from = pktrt__segment_vertices(seg, block, i > 5, true);
    vstore(planes[i / 6] + 8 * (i % 6), vload(from + 24 * (i % 2) + 8 * (i % 6 / 2)));
  }
  uint32_t left = pktrt__frustum_cull_children_moving(f, planes[0], planes[1], &entry, &whole);
  left &= pktrt__lanes_occupied(instance);
  vstore(nearest, entry);
  for (uint32_t c; left && mask; left &= ~(1u << c)) {
    c = pktrt__place_nearest(left, nearest);
    const uint64_t rays = pktrt__frustum_test_child_moving(f, b, planes[0] + c, planes[1] + c, mask);
    if (!rays) continue;
    const uint64_t found = pktrt__place_enter(NULL, scene, seg, b, f->list, rays, instance[c], is);
    hit |= found;
    if (is->occlusion) mask &= ~found;
  }
  return hit;
}
/* Traces a packet through what is below a leaf of the top level, or, if few of its rays are left, a node. */
SMALL uint64_t pktrt__place_packet(pktrt__frustum *f, const pktrt_scene *scene, const pktrt__bvh_segment *seg,
                                   pktrt__batch *b, uint64_t mask, uint32_t ref, bool thin, const pktrt__variant *is) {
  return thin ? pktrt__place_stream_in(NULL, scene, seg, b, f->list, mask, ref, is)
              : pktrt__place_frustum_leaf(f, scene, seg, b, ref & ~PKTRT__LEAF, mask, is);
}
/* Traces a packet through all trees of the top level; for occlusion marks the rays that are hit. */
SMALL void pktrt__place_frustum(pktrt__frustum *f, const pktrt_scene *scene, pktrt__batch *b, uint64_t mask,
                                const pktrt__variant *what) {
  const pktrt__variant is = pktrt__variant_moving(*what, true);
  for (uint32_t i = 0; i < 2; i++) {
    const pktrt_scene *top = i ? scene->boxes : scene->groups;
    for (uint32_t t = 0; top && t < top->bvh_count && mask; t++) {
      const uint32_t keys = top->bvhs[t].key_count;
      uint64_t hit = 0;
      pktrt__batch_packet_time_weights(b, f->base, keys);
      for (uint64_t rest = mask; rest;) {
        const uint32_t segment = keys > 2 ? b->segment[f->base + pktrt__lowest_bit(rest)] : 0;
        const uint64_t same = keys > 2 ? pktrt__drive_rays_of_segment(b, f->list, rest, segment) : rest;
        const pktrt__bvh_segment seg = pktrt__bvh_segment_of(top->bvhs, t, segment);
        pktrt__frustum_times(f, b, same);
        pktrt__frustum_update_depth(f, b, same);
        hit |= pktrt__frustum_template(f, &seg, b, same, scene, is);
        rest &= ~same;
      }
      if (is.occlusion) pktrt__drive_mark(b, f->base, hit), mask &= ~hit;
    }
  }
}
#endif
#endif

#if !defined(PKTRT_NO_PAPER) && PKTRT__WITH_PAPER
/* Traces rays [begin, end) of a batch of the paper path through the instances, 64 neighbours of one octant at a time. */
PKTRT__COLD void pktrt__place_packets(const pktrt__query *call, pktrt__batch *b, uint32_t begin, uint32_t end,
                                      const pktrt__variant *what) {
  pktrt_counts unwanted;
  pktrt__variant is = pktrt__variant_of(what->occlusion, true, PKTRT__STATS != 0, what->counts);
  is.mask = what->mask;
  memset(&unwanted, 0, sizeof unwanted);
  if (!call->counts) is.counts = &unwanted;
  for (uint32_t base = begin; base < end; base += 64) {
    uint8_t list[64];
    uint64_t rest = b->valid[base / 64];
    for (uint32_t i = 0; i < 64; i++) {
      list[i] = (uint8_t)(base + i);
      if (is.occlusion && !b->slot[base + i]) rest &= ~((uint64_t)1 << i);
    }
    while (rest) {
      const uint64_t same = rest & veq_u8x64(b->octant + base, b->octant[base + pktrt__lowest_bit(rest)]);
      pktrt__place_stream(call, call->scene, b, list, same, &is);
      rest &= ~same;
    }
  }
}
#endif
#endif /* PKTRT__NO_TOP */

/* >>entry ---------------------------------------------------------------------------------------------------------- */

/* Traces a single ray through all trees, of which there is mostly one, at rest. */
OP bool pktrt__entry_single(const pktrt_scene *scene, pktrt__single *q, const pktrt__variant is) {
  if (!scene->single_tree || COUNTED(is)) return pktrt__drive_single(scene, q, &is);
  return pktrt__single_traverse(&scene->bvhs->rest, q, 0, is);
}

/* Finds the closest hit of a single ray; at t = tmin, of triangles after one of the global index `after`. Tells its slot,
   tree and place, if `where` is not NULL. */
static bool pktrt__entry_intersect(const pktrt_scene *scene, const pktrt_ray *ray, uint32_t after, pktrt_hit *hit,
                                   uint32_t *where) {
  pktrt_counts unread; /* see PKTRT__VARIANTS */
  pktrt__single q;
  uint32_t hint[2] = {0, 0};
  if (!PKTRT__WITH_VECTORS) memset(&unread, 0, sizeof unread);
  const pktrt__variant is = pktrt__variant_of(false, false, false, &unread);
  bool found = pktrt__single_setup(scene, ray, &q);
  q.after = after;
  found = found && pktrt__entry_single(scene, &q, is);
  if (!found) {
    memset(hit, 0, sizeof *hit);
    hit->t = ray->tmax, hit->mesh = hit->triangle = PKTRT_NONE;
    return false;
  }
#if !defined(PKTRT_NO_INSTANCES)
  if (q.place) {
    pktrt__place_resolve(scene, q.place, q.bvh, q.slot, ray, q.there, hit);
  } else
#endif
    pktrt__single_resolve(scene, &q, hit);
  if (where) where[0] = q.slot, where[1] = q.bvh, where[2] = q.place;
  pktrt__mesh_name_triangle(scene, q.id, &q.place, hint, &hit->mesh, &hit->triangle);
  return true;
}
static bool pktrt__entry_occluded(const pktrt_scene *scene, const pktrt_ray *ray) {
  pktrt_counts unread;
  pktrt__single q;
  if (!PKTRT__WITH_VECTORS) memset(&unread, 0, sizeof unread);
  return pktrt__single_setup(scene, ray, &q) &&
         pktrt__entry_single(scene, &q, pktrt__variant_of(true, false, false, &unread));
}

/* Traces rays [begin, end) of a batch. */
static void pktrt__entry_trace(const pktrt__query *call, pktrt__batch *b, uint32_t begin, uint32_t end) {
  const pktrt_scene *scene = call->scene;
  pktrt_counts unread, *counts = call->counts;
#if !PKTRT__WITH_PAPER
  if (counts || call->desc->path == PKTRT_PATH_PAPER) {
    pktrt__entry_trace_avx2(call, b, begin, end);
    return;
  }
#endif
  if (!PKTRT__WITH_VECTORS && !counts) /* see PKTRT__VARIANTS */
    memset(&unread, 0, sizeof unread), counts = &unread;
  pktrt__variant is =
      pktrt__variant_of(call->occlusion, false, PKTRT__STATS && PKTRT__WITH_PAPER && call->counts, counts);
  is.mask = call->desc->mask;
  pktrt__batch_pad(b, end);
  memset(b->valid, 0, sizeof b->valid);
  for (uint32_t i = begin; i < end; i += FW) {
    const uint32_t valid = pktrt__batch_setup(scene, b, i);
    if (call->next) pktrt__prefetch_lines(call->next + i, FW * sizeof *call->next);
    b->valid[i / 64] |= (uint64_t)valid << (i % 64);
    COUNT(rays, pktrt__popcount(valid));
  }
  if (!scene->bvh_count && !pktrt__has_instances(scene)) {
    if (!is.occlusion) pktrt__resolve_batch(call, b, begin, end);
    return;
  }
#if !defined(PKTRT_NO_PAPER) && PKTRT__WITH_PAPER
  if (call->desc->path == PKTRT_PATH_PAPER) {
    pktrt__drive_paper(call, scene, b, begin, end, is.occlusion);
#ifndef PKTRT__NO_TOP
    if (scene->has_top) pktrt__place_packets(call, b, begin, end, &is);
#endif
  } else
#endif
      if (call->desc->path == PKTRT_PATH_SINGLE || pktrt__too_few(end - begin, is.occlusion)) {
    for (uint32_t i = begin; i < end; i += 64)
      for (uint64_t m = b->valid[i / 64]; m; m &= m - 1) {
        COUNT(packets, 1);
        pktrt__drive_batch_ray(scene, b, i + pktrt__lowest_bit(m), &is);
      }
  } else {
    pktrt__drive_fast(scene, b, begin, end, &is);
  }
  if (is.stats)
    for (uint32_t i = begin; i < end; i++) is.counts->hits += b->slot[i] != PKTRT_NONE;
  if (!is.occlusion) pktrt__resolve_batch(call, b, begin, end);
}

/* >>arrays ---------------------------------------------------------------------------------------------------------

   Copies arrays of structures to batches and back: eight rays or hits are eight rows of eight floats (and a time). */

static void pktrt__batch_load_rays(pktrt__batch *b, const pktrt_ray *rays, const uint16_t *order, uint32_t n) {
  uint32_t i = 0;
#if PKTRT__WITH_V8_REGISTERS
  for (; i + 8 <= n; i += 8) {
    v8 r[8];
    UNROLL for (uint32_t j = 0; j < 8; j++) {
      const pktrt_ray *from = &rays[pktrt__batch_place(order, i + j)];
      r[j] = vload((const float *)(const void *)from);
      b->time[i + j] = from->time;
    }
    vtranspose(r);
    UNROLL for (int a = 0; a < 3; a++) vstore(b->o[a] + i, r[a]), vstore(b->d[a] + i, r[a + 4]);
    vstore(b->tmin + i, r[3]), vstore(b->tmax + i, r[7]);
  }
#endif
  pktrt__batch_load_rest(b, rays, order, i, n);
}
/* Finds meshes and triangles of n hits, at most eight: of eight together, where they are of one mesh. */
PKTRT__NOINLINE void pktrt__batch_name_hits(const pktrt_scene *s, const pktrt__batch *b, uint32_t i, uint32_t n,
                                            uint32_t hint[2], uint32_t *mesh, uint32_t *triangle) {
#if PKTRT__WITH_V8_REGISTERS
  const pktrt__mesh *m = n == 8 && s->bvh_count ? &s->meshes[hint[0]] : NULL;
  if (m && m->triangle_count && vbelow_u32(triangle, b->id + i, m->first_id, m->triangle_count) == 0xFF)
    vstore_masked_u32(mesh, mfrom(0xFF), hint[0]);
  else
#endif
    for (uint32_t j = 0; j < n; j++)
      pktrt__mesh_name_triangle(s, b->id[i + j], b->place + i + j, hint, &mesh[j], &triangle[j]);
}
static void pktrt__batch_store_names(const pktrt_scene *s, const pktrt__batch *b, uint32_t *mesh, uint32_t *triangle,
                                     uint32_t n) {
  uint32_t hint[2] = {0, 0}, unread[8];
  for (uint32_t i = 0; i < n; i += 8)
    pktrt__batch_name_hits(s, b, i, n - i < 8 ? n - i : 8, hint, mesh ? mesh + i : unread,
                           triangle ? triangle + i : unread);
}
static void pktrt__batch_store_hits(const pktrt_scene *s, const pktrt__batch *b, pktrt_hit *hits, const uint16_t *order,
                                    uint32_t n) {
  uint32_t i = 0;
#if PKTRT__WITH_V8_REGISTERS
  uint32_t hint[2] = {0, 0};
  for (; i + 8 <= n; i += 8) {
    PKTRT__ALIGN64 uint32_t mesh[8], triangle[8];
    pktrt__batch_name_hits(s, b, i, 8, hint, mesh, triangle);
    v8 r[8] = {vload(b->t + i), vload(b->as.hit.u + i), vload(b->as.hit.v + i)};
    UNROLL for (int a = 0; a < 3; a++) r[3 + a] = vload(b->as.hit.normal[a] + i);
    r[6] = vload((const float *)(const void *)mesh), r[7] = vload((const float *)(const void *)triangle);
    vtranspose(r);
    UNROLL for (uint32_t j = 0; j < 8; j++) vstore((float *)(void *)&hits[pktrt__batch_place(order, i + j)], r[j]);
  }
#endif
  pktrt__batch_store_rest(s, b, hits, order, i, n);
}
static void pktrt__batch_copy_row(float *to, const float *from, uint32_t n) {
  uint32_t i = 0;
  for (; i + 8 <= n; i += 8) vstore(to + i, vload(from + i));
  for (; i < n; i++) to[i] = from[i];
}
static void pktrt__batch_store_occluded(const pktrt__batch *b, bool *occluded, uint32_t n) {
  uint32_t i = 0;
  for (; i + 8 <= n && sizeof(bool) == 1; i += 8)
    pktrt__store_bytes(occluded + i, vbytes(~pktrt__lanes_unhit(b->slot + i)));
  for (; i < n; i++) occluded[i] = b->slot[i] != PKTRT_NONE;
}

/* >>selftest: what the compiler made of the vectors ---------------------------------------------------------------- */

OP v8 pktrt__check_value(float x) { return vset((float)pktrt__check_opaque((double)x)); }
OP bool pktrt__check_all(m8 m) { return mbits(m) == 0xFF; }
/* Returns what the compiler did to this instruction set's operations, see pktrt__check_all_arithmetic. Equal products
   have operands of their own: a product that is used twice would not be fused. */
PKTRT__DIVIDES_BY_ZERO PKTRT__COLD uint32_t pktrt__check_arithmetic(void) {
  const v8 one = pktrt__check_value(1), a = pktrt__check_value(1.000244140625f), b = pktrt__check_value(1.00048828125f);
  const v8 c = pktrt__check_value(1.000244140625f), d = pktrt__check_value(1.00048828125f),
           big = pktrt__check_value(33554432);
  const v8 divisor = pktrt__check_value(41), nothing = pktrt__check_value(0), negative = pktrt__check_value(-0.0f),
           zero = vset(0);
  const v8 infinite = vdiv(one, nothing), nan = vsub(infinite, infinite);
  const v8 q5 = vdiv(pktrt__check_value(5), divisor), q7 = vdiv(pktrt__check_value(7), divisor);
  const v8 root = vsqrt(pktrt__check_value(2)), root3 = vsqrt(pktrt__check_value(3)),
           root7 = vsqrt(pktrt__check_value(7));
  const bool apart = pktrt__check_all(mand(veq(vsub(vmul(a, a), b), zero), veq(vsub(d, vmul(c, c)), zero)));
  const bool in_order = pktrt__check_all(veq(vsub(vadd(one, big), big), zero));
  const bool divides = pktrt__check_all(mand(veq(q5, vset(0.121951222f)), veq(q7, vset(0.170731708f)))) &&
                       pktrt__check_all(veq(vdiv(one, root), vset(0.707106769f)));
  const bool roots = pktrt__check_all(mand(veq(root, vset(1.41421354f)), veq(root3, vset(1.73205078f)))) &&
                     pktrt__check_all(veq(root7, vset(2.64575124f)));
  const m8 ordered = mor(mor(veq(nan, nan), vle(nan, one)), mor(vle(one, nan), veq(vmin(one, nan), one)));
  const bool infinities =
      pktrt__check_all(mand(mand(vlt(one, infinite), veq(infinite, infinite)), veq(vmax(nan, one), one)));
  const bool signs =
      !vsignbits(vadd(negative, zero)) && !vsignbits(vsub(zero, nothing)) && !vsignbits(vmin(negative, nothing));
  return (apart ? 0 : PKTRT__FUSES) | (in_order ? 0 : PKTRT__REORDERS) | (divides ? 0 : PKTRT__MULTIPLIES) |
         (roots ? 0 : PKTRT__GUESSES_ROOTS) | (infinities && !mbits(ordered) ? 0 : PKTRT__EXPECTS_FINITE) |
         (signs ? 0 : PKTRT__DROPS_SIGNS);
}

/* >>table ---------------------------------------------------------------------------------------------------------- */

#if !defined(PKTRT_NO_RENDER) && !PKTRT__WITH_SHADE
#define PKTRT__RENDER_KERNELS                                                                              \
  , PKTRT__BASE(pktrt__camera_rays8), PKTRT__BASE(pktrt__surface_pack), PKTRT__BASE(pktrt__surface_find),  \
      PKTRT__BASE(pktrt__material_evaluate), PKTRT__BASE(pktrt__light_shadow_rays),                        \
      PKTRT__BASE(pktrt__light_visibility), PKTRT__BASE(pktrt__light_add), PKTRT__BASE(pktrt__spawn_rays), \
      PKTRT__BASE(pktrt__sampler_draw)
#elif !defined(PKTRT_NO_RENDER)
#define PKTRT__RENDER_KERNELS                                                                                          \
  , pktrt__camera_rays8, pktrt__surface_pack, pktrt__surface_find, PKTRT__MATERIAL_EVALUATE, pktrt__light_shadow_rays, \
      pktrt__light_visibility, pktrt__light_add, PKTRT__SPAWN_RAYS, pktrt__sampler_draw
#else
#define PKTRT__RENDER_KERNELS
#endif
static const pktrt__kernel_table pktrt__kernels = {
    pktrt__entry_trace,          pktrt__entry_intersect, pktrt__entry_occluded,
    pktrt__check_arithmetic,     pktrt__batch_load_rays, pktrt__batch_store_hits,
    pktrt__batch_store_occluded, pktrt__batch_copy_row,  pktrt__batch_store_names PKTRT__RENDER_KERNELS};

#ifdef PKTRT__ALSO_STAMP /* for benchmarks: the quoted path, from here, of a file on the same vectors */
#include PKTRT__ALSO_STAMP
#endif

/* Undefines the short names, which end with the stamp. */
#undef a8
#undef aor
#undef apush
#undef vmax_abs
#undef vmax_abs3
#undef azero
#undef d8
#undef dabs
#undef dadd
#undef ddiv
#undef dfrom
#undef dlt
#undef dmax
#undef dmul
#undef dsel
#undef dset
#undef dsub
#undef dto
#undef vsqrt
#undef dload
#undef dstore
#undef d8_of
#undef dsqrt
#undef fabs_
#undef fadd
#undef fbits
#undef ffma
#undef ffms
#undef ffrom
#undef fdiv
#undef fstore_masked
#undef fstore_masked_u32
#undef fhmax
#undef fhmin
#undef fle
#undef fmin_masked
#undef fmax_masked
#undef fload
#undef flt
#undef feq
#undef fmand
#undef fmor
#undef fmax_
#undef fmin_
#undef fmul
#undef fsel
#undef fsignbits
#undef fcopysign
#undef fset
#undef fwide
#undef fstore
#undef fsub
#undef m8
#undef mand
#undef mbits
#undef mf
#undef mfrom
#undef mturn
#undef mor
#undef v8
#undef vabs
#undef vadd
#undef vdiv
#undef veq
#undef vf
#undef vfma
#undef vfms
#undef vhmax
#undef vhmin
#undef veq_u32
#undef c8
#undef vchoose
#undef vcompress
#undef vcompress_from
#undef vle
#undef vload
#undef vlt
#undef vmax
#undef vmin
#undef vmul
#undef vstore_masked
#undef vstore_masked_u32
#undef vsel
#undef vset
#undef vsignbits
#undef vstore
#undef vtranspose
#undef vbelow_u32
#undef vorder_children
#undef vbytes
#undef vstore_bytes
#undef veq_u8x64
#undef vsub
#undef vswap_halves
#undef vload_turn
#undef vstore_turn
#undef vturn
#undef PKTRT__TURNS
#undef PKTRT__TURN_LANES
#undef PKTRT__TURN_MASK
#undef vcopysign
#undef FW
#undef OP
#undef UNROLL
#undef UNROLL_WIDE
#undef PKTRT__WITH_FIT
#undef PKTRT__WITH_PAPER
#undef PKTRT__WITH_PAPER_PATH
#undef PKTRT__BASE
#undef PKTRT__WITH_SHADE
#undef PKTRT__RENDER_KERNELS
#undef STEP
#undef SHARED
#undef PKTRT__SPAWN_RAYS
#undef PKTRT__MATERIAL_EVALUATE
#undef SMALL
#undef ROLL_OUT
#undef COUNT
#undef COUNTED
#undef PKTRT__WITH_FEW_INSTANCES
#undef PKTRT__WITH_TOP_FRUSTA
#undef FRUSTA
#undef IF_COUNTED
#undef PKTRT__PICK
#undef PKTRT__VARIANTS
#undef IF_FAST
#undef pktrt__drive_paper
#undef IF_MOVING

#ifdef PKTRT__EDITOR
#undef PKTRT__STAMP
#undef PKTRT__SUFFIX
#endif

#endif /* PKTRT__STAMP */

/* ---------------------------------------------------------------------------------------------------------------------
   IMPLEMENTATION of the public functions, compiled once
   ------------------------------------------------------------------------------------------------------------------ */
#if defined(PKTRT_IMPLEMENTATION) && !defined(PKTRT__STAMP) && !defined(PKTRT__ENTRY_POINTS)
#define PKTRT__ENTRY_POINTS

/* >>dispatch ------------------------------------------------------------------------------------------------------- */

#if defined(PKTRT__HAS_AVX2) || defined(PKTRT__HAS_AVX512)
/* Tells whether the CPU has the instructions and the operating system saves the registers: both are needed. */
static bool pktrt__cpu_has(pktrt_isa isa) {
  unsigned a, b, c, d, lo, hi;
  if (!__get_cpuid(1, &a, &b, &c, &d)) return false;
  if ((c & 0x18801000u) != 0x18801000u) return false; /* FMA, POPCNT, OSXSAVE, AVX */
  __asm__ volatile("xgetbv" : "=a"(lo), "=d"(hi) : "c"(0));
  if (!__get_cpuid_count(7, 0, &a, &b, &c, &d) || (lo & 6) != 6) return false;
  if ((b & 0x128u) != 0x128u) return false;                                                  /* BMI, AVX2, BMI2 */
  return isa == PKTRT_ISA_AVX2 || ((b & 0xC0030000u) == 0xC0030000u && (lo & 0xE6) == 0xE6); /* F, DQ, BW, VL */
}
#endif

static const pktrt__kernel_table *pktrt__kernels_of(pktrt_isa isa) {
  switch (isa) {
#ifdef PKTRT__HAS_SCALAR
  case PKTRT_ISA_SCALAR: return &pktrt__kernels_scalar;
#endif
#ifdef PKTRT__HAS_SSE2
  case PKTRT_ISA_SSE2: return &pktrt__kernels_sse2;
#endif
#ifdef PKTRT__HAS_AVX2
  case PKTRT_ISA_AVX2: return pktrt__cpu_has(isa) ? &pktrt__kernels_avx2 : NULL;
#endif
#ifdef PKTRT__HAS_AVX512
  case PKTRT_ISA_AVX512: return pktrt__cpu_has(isa) ? &pktrt__kernels_avx512 : NULL;
#endif
#ifdef PKTRT__HAS_NEON
  case PKTRT_ISA_NEON: return &pktrt__kernels_neon;
#endif
#ifdef PKTRT__HAS_WASM
  case PKTRT_ISA_WASM: return &pktrt__kernels_wasm;
#endif
  default: return NULL;
  }
}

static const pktrt__fit_table *pktrt__fit_table_of(pktrt_isa isa) {
#ifdef PKTRT__HAS_AVX2
  if (isa == PKTRT_ISA_AVX2 || isa == PKTRT_ISA_AVX512) return &pktrt__fit_kernels_avx2;
#endif
  (void)isa;
#if defined(PKTRT__HAS_SSE2)
  return &pktrt__fit_kernels_sse2;
#elif defined(PKTRT__HAS_NEON)
  return &pktrt__fit_kernels_neon;
#elif defined(PKTRT__HAS_WASM)
  return &pktrt__fit_kernels_wasm;
#elif defined(PKTRT__HAS_SCALAR)
  return &pktrt__fit_kernels_scalar;
#elif defined(PKTRT__HAS_AVX2)
  return &pktrt__fit_kernels_avx2;
#else
  return &pktrt__fit_kernels_avx512;
#endif
}

static pktrt_isa pktrt__isa_widest(void) {
  static const pktrt_isa widest_first[] = {PKTRT_ISA_AVX512, PKTRT_ISA_AVX2, PKTRT_ISA_SSE2, PKTRT_ISA_NEON,
                                           PKTRT_ISA_WASM};
  for (size_t i = 0; i < sizeof widest_first / sizeof *widest_first; i++)
    if (pktrt__kernels_of(widest_first[i])) return widest_first[i];
  return PKTRT_ISA_SCALAR;
}

static const char *const pktrt__isa_name[] = {"auto", "scalar", "sse2", "avx2", "avx512", "neon", "wasm"};
PKTRT__STATIC_ASSERT(each_isa_has_a_name, sizeof pktrt__isa_name / sizeof(char *) == (size_t)PKTRT_ISA_COUNT);
PKTRT_DEF const char *pktrt_isa_string(pktrt_isa isa) {
  return (int)isa < 0 || isa >= PKTRT_ISA_COUNT ? "unknown" : pktrt__isa_name[isa];
}

PKTRT_DEF bool pktrt_isa_available(pktrt_isa isa) { return isa == PKTRT_ISA_AUTO || pktrt__kernels_of(isa) != NULL; }

/* >>scene ---------------------------------------------------------------------------------------------------------- */

PKTRT_DEF const char *pktrt_status_string(pktrt_status status) {
  switch (status) {
  case PKTRT_OK: return "Everything went well.";
  case PKTRT_INVALID_ARGUMENT: return "An argument makes no sense; pktrt_last_error says which.";
  case PKTRT_OUT_OF_MEMORY: return "An allocation failed; the last committed state stays.";
  case PKTRT_LIMIT: return "A documented limit would be passed; pktrt_last_error says which.";
  case PKTRT_NOT_COMMITTED: return "The scene has changes that need pktrt_commit first.";
  case PKTRT_CANCELLED: return "The progress hook asked to stop.";
  default: return "This is not a status of pktrt.";
  }
}

PKTRT_DEF uint32_t pktrt_version(void) { return PKTRT_VERSION; }

static uint32_t pktrt__check_all_arithmetic(const pktrt__kernel_table *kernels) {
  return pktrt__check_thread() | pktrt__check_compiler() | kernels->check_arithmetic();
}

PKTRT_DEF const char *pktrt_last_error(const pktrt_scene *s) {
  if (s) return s->error;
  uint32_t faults = 0;
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) {
    const pktrt__kernel_table *kernels = pktrt__kernels_of((pktrt_isa)isa);
    if (kernels) faults |= pktrt__check_all_arithmetic(kernels);
  }
  return pktrt__check_sentence(faults);
}

PKTRT__COLD void pktrt__instance_free(const pktrt_scene *s, pktrt__instance *in) {
  pktrt__mem_release(&s->desc, in->keys, in->key_count, 12 * sizeof(float));
  pktrt__mem_release(&s->desc, in->pending, in->key_count, 12 * sizeof(float));
}
/* Computes how an instance lies at its first key, and whether it has diagonals at all. */
static void pktrt__place_rest(pktrt__instance *in) {
  pktrt__place_mix(in->keys, in->keys, 1, 0, pktrt__place_is_straight(in->keys, in->key_count), &in->rest);
  pktrt__place_invert(&in->rest);
}
/* Takes over the transforms that were set, as pktrt__commit_promote does positions, and what else waits. */
PKTRT__COLD void pktrt__instance_promote_all(pktrt_scene *s) {
  for (uint32_t i = 0; i < s->instance_count; i++) {
    pktrt__instance *in = &s->instances[i];
    in->seen = in->hide ? 0 : in->mask;
    if (in->gone) {
      pktrt__instance_free(s, in);
      in->keys = in->pending = NULL, in->gone = in->dirty = false, in->free = true, in->kappa = 0;
      s->free_instances++;
    }
    if (!in->dirty) continue;
    if (in->pending) pktrt__commit_swap(&in->keys, &in->pending);
    pktrt__place_rest(in);
    in->dirty = false;
  }
}
PKTRT__COLD void pktrt__instance_free_all(pktrt_scene *s) {
  for (uint32_t i = 0; i < s->instance_count; i++) pktrt__instance_free(s, &s->instances[i]);
  for (uint32_t i = 0; i < s->model_count; i++) pktrt_scene_destroy(s->models[i]);
  pktrt__mem_release(&s->desc, s->instances, s->instance_capacity, sizeof *s->instances);
  pktrt__mem_release(&s->desc, s->models, s->model_capacity, sizeof *s->models);
  pktrt_scene_destroy(s->boxes);
}

PKTRT_DEF pktrt_scene *pktrt_scene_create(const pktrt_scene_desc *desc) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  if (desc) d = *desc;
  if (!d.allocate != !d.release) return NULL;
  if ((int)d.quality < 0 || d.quality > PKTRT_BUILD_HIGH || (int)d.rebuild < 0 || d.rebuild > PKTRT_REBUILD_AUTOMATIC)
    return NULL;
  if (!d.allocate) d.allocate = pktrt__mem_malloc, d.release = pktrt__mem_free;
  if (d.isa == PKTRT_ISA_AUTO) d.isa = pktrt__isa_widest();
  const pktrt__kernel_table *kernels = pktrt__kernels_of(d.isa);
  if (!kernels || pktrt__check_all_arithmetic(kernels)) return NULL;
  pktrt_scene *s = PKTRT__CAST(pktrt_scene *, pktrt__mem_alloc(&d, 1, sizeof *s));
  if (!s) return NULL;
  memset(s, 0, sizeof *s);
  s->desc = d;
  s->isa = d.isa;
  s->kernels = kernels;
#ifndef PKTRT_NO_RENDER
  for (int a = 0; a < 3; a++) s->plain.albedo[a] = 0.8f;
#endif
  pktrt__commit_summarise(s);
  return s;
}

PKTRT_DEF void pktrt_scene_destroy(pktrt_scene *s) {
  if (!s) return;
  const pktrt_scene_desc d = s->desc;
  for (uint32_t i = 0; i < s->mesh_count; i++) pktrt__mesh_free(&d, &s->meshes[i]);
  for (uint32_t i = 0; i < s->bvh_count; i++) pktrt__bvh_free(&d, &s->bvhs[i]);
  pktrt__mem_release(&d, s->meshes, s->mesh_capacity, sizeof *s->meshes);
  pktrt__mem_release(&d, s->bvhs, s->bvh_room, sizeof *s->bvhs);
  pktrt__mem_release(&d, s->sets, s->set_capacity, sizeof *s->sets);
  pktrt_scene_destroy(s->groups);
  pktrt__instance_free_all(s);
#ifndef PKTRT_NO_RENDER
  pktrt__mem_release(&d, s->materials, s->material_capacity, sizeof *s->materials);
  pktrt__mem_release(&d, s->lights, s->light_capacity, sizeof *s->lights);
  pktrt__environment_free(&d, s->environment);
#endif
  pktrt__mem_release(&d, s, 1, sizeof *s);
}

/* Returns the set that a mesh belongs to, a new one or an empty one if there is none; PKTRT_NONE: no memory. */
PKTRT__COLD uint32_t pktrt__set_of(pktrt_scene *s, const pktrt_mesh_desc *d, uint32_t mesh) {
  const uint32_t keys = d->key_count ? d->key_count : 1, mask = d->mask ? d->mask : UINT32_MAX;
  uint32_t i = s->set_count, vacant = i;
  while (i-- && !(s->sets[i].group == d->group && s->sets[i].key_count == keys && s->sets[i].mask == mask))
    if (!s->sets[i].meshes && s->sets[i].tree == PKTRT_NONE) vacant = i;
  if (i == PKTRT_NONE) {
    void *sets = s->sets;
    pktrt__set made;
    if (!pktrt__mem_grow(&s->desc, &sets, vacant, &s->set_capacity, sizeof made)) return PKTRT_NONE;
    memset(&made, 0, sizeof made);
    made.group = d->group, made.key_count = keys, made.mask = mask, made.first_mesh = mesh, made.tree = PKTRT_NONE;
    s->sets = PKTRT__CAST(pktrt__set *, sets), s->sets[i = vacant] = made, s->set_count += vacant == s->set_count;
  }
  if (mesh < s->sets[i].first_mesh) s->sets[i].first_mesh = mesh;
  if (mesh >= s->sets[i].end_mesh) s->sets[i].end_mesh = mesh + 1;
  return i;
}

/* Finds an index for so many triangles: the first that waits for them, or the next. */
PKTRT__COLD uint32_t pktrt__mesh_find_index(const pktrt_scene *s, uint32_t triangles) {
  for (uint32_t i = 0; s->free_meshes && i < s->mesh_count; i++) {
    const uint32_t end = i + 1 < s->mesh_count ? s->meshes[i + 1].first_id : s->total_triangles;
    if (s->meshes[i].free && !s->meshes[i].instance && end - s->meshes[i].first_id >= triangles) return i;
  }
  return s->mesh_count;
}

/* Adds a mesh at an index. */
PKTRT__COLD pktrt_status pktrt__mesh_add(pktrt_scene *s, const pktrt_mesh_desc *d, uint32_t index) {
  void *meshes = s->meshes;
  pktrt__mesh m;
  memset(&m, 0, sizeof m);
  m.set = pktrt__set_of(s, d, index);
  if (m.set == PKTRT_NONE || !pktrt__mem_grow(&s->desc, &meshes, s->mesh_count, &s->mesh_capacity, sizeof m))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "mesh %u: no memory for the list of meshes", (unsigned)index);
  s->meshes = PKTRT__CAST(pktrt__mesh *, meshes);
  m.vertex_count = d->vertex_count;
  m.triangle_count = d->triangle_count;
  m.key_count = d->key_count ? d->key_count : 1;
  m.stride = d->position_stride ? d->position_stride : 12;
  m.material = d->material;
  m.first_id = index < s->mesh_count ? s->meshes[index].first_id : s->total_triangles;
  const pktrt_status st = pktrt__mesh_copy(s, d, &m, index);
  if (st != PKTRT_OK) {
    pktrt__mesh_free(&s->desc, &m);
    return st;
  }
  if (index == s->mesh_count) s->mesh_count++, s->total_triangles += m.triangle_count;
  else s->free_meshes -= !s->meshes[index].instance;
  s->meshes[index] = m, s->sets[m.set].meshes++;
  return PKTRT_OK;
}

PKTRT_DEF pktrt_status pktrt_add_mesh(pktrt_scene *s, const pktrt_mesh_desc *d, uint32_t *mesh) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  const uint32_t index = pktrt__mesh_find_index(s, d ? d->triangle_count : 0);
  pktrt_status st = pktrt__mesh_check(s, d, index);
  if (st == PKTRT_OK) st = pktrt__mesh_add(s, d, index);
  if (st == PKTRT_OK && mesh) *mesh = index;
  return st;
}

PKTRT_DEF pktrt_status pktrt_commit(pktrt_scene *s) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  pktrt__commit_list own, top;
  pktrt_status st = pktrt__commit_build_changed(s, s, &own);
  if (st != PKTRT_OK) return st;
  if (s->boxes) st = pktrt__commit_build_changed(s->boxes, s, &top);
  if (st != PKTRT_OK) {
    pktrt__commit_drop(s, &own);
    return st;
  }
  pktrt__commit_take(s, &own);
  if (s->boxes) pktrt__commit_take(s->boxes, &top), pktrt__commit_summarise(s->boxes), pktrt__instance_promote_all(s);
  pktrt__commit_summarise(s);
  return PKTRT_OK;
}

/* Returns the instance that a call names, or NULL and a detail. */
PKTRT__COLD pktrt__instance *pktrt__instance_named(pktrt_scene *s, uint32_t instance, const char *what) {
  s->error[0] = 0;
  if (instance < s->instance_count && !s->instances[instance].gone && !s->instances[instance].free)
    return &s->instances[instance];
  if (instance < s->instance_count)
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: instance %u was removed", what, (unsigned)instance);
  else
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: there is no instance %u among %u", what, (unsigned)instance,
                (unsigned)s->instance_count);
  return NULL;
}
/* Returns the mesh that a call names, or NULL and a detail. */
PKTRT__COLD pktrt__mesh *pktrt__mesh_named(pktrt_scene *s, uint32_t mesh, const char *what) {
  s->error[0] = 0;
  if (mesh < s->mesh_count && !s->meshes[mesh].gone && !s->meshes[mesh].free) return &s->meshes[mesh];
  if (mesh < s->mesh_count) pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: mesh %u was removed", what, (unsigned)mesh);
  else
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: there is no mesh %u among %u", what, (unsigned)mesh,
                (unsigned)s->mesh_count);
  return NULL;
}
PKTRT__COLD pktrt__mesh *pktrt__mesh_to_deform(pktrt_scene *s, uint32_t mesh, uint32_t key, const float *data,
                                               const char *what) {
  pktrt__mesh *m = pktrt__mesh_named(s, mesh, what);
  if (!m) return NULL;
  if (m->instance) {
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: mesh %u belongs to instance %u, whose model keeps its shape", what,
                (unsigned)mesh, (unsigned)m->instance - 1);
    return NULL;
  }
  if (key >= m->key_count) {
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: mesh %u has no key %u, it has %u", what, (unsigned)mesh, (unsigned)key,
                (unsigned)m->key_count);
    return NULL;
  }
  if (!data && m->vertex_count) {
    pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s: mesh %u, key %u: the array is NULL", what, (unsigned)mesh,
                (unsigned)key);
    return NULL;
  }
  return m;
}

/* Puts one key of new vectors into a waiting copy of `current`, or refuses and leaves all as it was. */
static pktrt_status pktrt__mesh_set_vectors(pktrt_scene *s, pktrt__mesh *m, float *current, float **pending,
                                            bool *dirty, const pktrt__mesh_vectors *v) {
  const uint64_t floats = pktrt__mesh_floats(m), at = (uint64_t)v->key * m->vertex_count * 3;
  float checked[3 * 64]; /* look at everything before the first write */
  for (uint32_t i = 0; i < v->count; i += 64) {
    pktrt__mesh_vectors part = *v;
    part.from = (const float *)(const void *)((const unsigned char *)(const void *)v->from + (size_t)i * v->stride);
    part.count = v->count - i < 64 ? v->count - i : 64;
    const pktrt_status st = pktrt__mesh_copy_vectors(s, checked, &part);
    if (st != PKTRT_OK) return st;
  }
  const bool current_inside = *pending && *dirty;
  if (!*pending) {
    *pending = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, floats, sizeof(float)));
    if (!*pending)
      return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "mesh %u: no memory for %u changed vectors", (unsigned)v->mesh,
                         (unsigned)m->vertex_count);
  }
  if (!current_inside && m->key_count > 1) memcpy(*pending, current, (size_t)floats * sizeof(float));
  *dirty = true;
  return v->count ? pktrt__mesh_copy_vectors(s, *pending + at, v) : PKTRT_OK;
}

PKTRT_DEF pktrt_status pktrt_set_positions(pktrt_scene *s, uint32_t mesh, uint32_t key, const float *positions) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  pktrt__mesh *m = pktrt__mesh_to_deform(s, mesh, key, positions, "set_positions");
  if (!m) return PKTRT_INVALID_ARGUMENT;
  const pktrt__mesh_vectors v = {positions, m->vertex_count, m->stride, PKTRT_MAX_COORD, mesh, key, "vertex"};
  return pktrt__mesh_set_vectors(s, m, m->positions, &m->pending, &m->dirty, &v);
}

#ifndef PKTRT_NO_NORMALS
PKTRT_DEF pktrt_status pktrt_set_normals(pktrt_scene *s, uint32_t mesh, uint32_t key, const float *normals) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  pktrt__mesh *m = pktrt__mesh_to_deform(s, mesh, key, normals, "set_normals");
  if (!m) return PKTRT_INVALID_ARGUMENT;
  if (!m->normals)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "set_normals: mesh %u was added without normals", (unsigned)mesh);
  const pktrt__mesh_vectors v = {normals, m->vertex_count, 12, FLT_MAX, mesh, key, "normal"};
  return pktrt__mesh_set_vectors(s, m, m->normals, &m->pending_normals, &m->dirty_normals, &v);
}
#endif

PKTRT_DEF pktrt_status pktrt_refit(pktrt_scene *s) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    if (m->free || (m->committed && !m->gone)) continue;
    return pktrt__fail(s, PKTRT_NOT_COMMITTED, "refit: %s %u was %s since the last commit",
                       m->instance ? "instance" : "mesh", (unsigned)(m->instance ? m->instance - 1 : i),
                       m->gone ? "removed" : "added");
  }
  pktrt__commit_survey(s);
  pktrt__commit_fit_moved(s);
  for (uint32_t i = 0; i < s->mesh_count; i++) pktrt__commit_promote(&s->meshes[i]);
  if (s->boxes && !pktrt_refit(s->boxes)) pktrt__instance_promote_all(s);
  pktrt__commit_summarise(s);
  return pktrt__commit_rebuild_worn(s);
}

#ifndef PKTRT_NO_REMOVAL
PKTRT_DEF pktrt_status pktrt_remove_mesh(pktrt_scene *s, uint32_t mesh) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  pktrt__mesh *m = pktrt__mesh_named(s, mesh, "remove_mesh");
  if (!m) return PKTRT_INVALID_ARGUMENT;
  if (m->instance)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "remove_mesh: mesh %u belongs to instance %u, which goes as a whole",
                       (unsigned)mesh, (unsigned)m->instance - 1);
  m->gone = true;
  return PKTRT_OK;
}

/* Tells the range of meshes that go with one: all of its instance. */
PKTRT__COLD pktrt__mesh *pktrt__mesh_with_others(const pktrt_scene *s, pktrt__mesh *m, uint32_t *count) {
  *count = 1;
  if (!m->instance) return m;
  *count = s->instances[m->instance - 1].model->mesh_count;
  return &s->meshes[s->instances[m->instance - 1].first_mesh];
}

PKTRT_DEF pktrt_status pktrt_set_enabled(pktrt_scene *s, uint32_t mesh, bool enabled) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  uint32_t count = 0;
  pktrt__mesh *m = pktrt__mesh_named(s, mesh, "set_enabled");
  if (!m) return PKTRT_INVALID_ARGUMENT;
  if (m->instance) s->instances[m->instance - 1].hide = !enabled;
  m = pktrt__mesh_with_others(s, m, &count);
  for (uint32_t i = 0; i < count; i++) m[i].hide = !enabled;
  return PKTRT_OK;
}

#ifndef PKTRT_NO_INSTANCES
PKTRT_DEF pktrt_status pktrt_remove_instance(pktrt_scene *s, uint32_t instance) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  uint32_t count = 0;
  pktrt__instance *in = pktrt__instance_named(s, instance, "remove_instance");
  if (!in) return PKTRT_INVALID_ARGUMENT;
  pktrt__mesh *m = pktrt__mesh_with_others(s, &s->meshes[in->first_mesh], &count);
  for (uint32_t i = 0; i < count; i++) m[i].gone = true;
  in->gone = s->boxes->meshes[instance].gone = true;
  return PKTRT_OK;
}
#endif
#endif

PKTRT_DEF pktrt_status pktrt_mark_changed(pktrt_scene *s) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  for (uint32_t i = 0; i < s->mesh_count; i++) s->meshes[i].marked = !s->meshes[i].free;
  return s->boxes ? pktrt_mark_changed(s->boxes) : PKTRT_OK;
}

#ifndef PKTRT_NO_INSTANCES
PKTRT_DEF pktrt_status pktrt_add_model(pktrt_scene *s, const pktrt_mesh_desc *meshes, uint32_t mesh_count,
                                       uint32_t *model) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  const unsigned index = (unsigned)s->model_count;
  if (!meshes || !mesh_count) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "model %u: it has no meshes", index);
  void *models = s->models;
  if (!pktrt__mem_grow(&s->desc, &models, s->model_count, &s->model_capacity, sizeof *s->models))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "model %u: no memory for the list of models", index);
  s->models = PKTRT__CAST(pktrt_scene **, models);
  pktrt_scene *m = pktrt_scene_create(&s->desc);
  if (!m) return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "model %u: no memory", index);
  pktrt_status st = PKTRT_OK;
  for (uint32_t i = 0; i < mesh_count && st == PKTRT_OK; i++) {
    pktrt_mesh_desc mesh = meshes[i];
    mesh.group = 0; /* it is built once */
    st = pktrt_add_mesh(m, &mesh, NULL);
  }
  if (st == PKTRT_OK) st = pktrt_commit(m);
  if (st != PKTRT_OK) {
    pktrt__fail(s, st, "model %u: %.200s", index, m->error);
    pktrt_scene_destroy(m);
    return st;
  }
  s->models[s->model_count++] = m;
  if (model) *model = index;
  return PKTRT_OK;
}

/* Computes det(a) with row i, if it is one, taken from b. */
static double pktrt__place_det(double a[3][3], double b[3][3], int i) {
  const double *x = i == 0 ? b[0] : a[0], *y = i == 1 ? b[1] : a[1], *z = i == 2 ? b[2] : a[2];
  return x[0] * (y[1] * z[2] - y[2] * z[1]) + x[1] * (y[2] * z[0] - y[0] * z[2]) + x[2] * (y[0] * z[1] - y[1] * z[0]);
}
/* Finds the least Bernstein coefficient of the determinant between two keys, whose columns have been scaled to at most 1
   in common; below 0 if not all have the sign of the first. */
static double pktrt__place_least_det(const float *k0, const float *k1) {
  double a[3][3], b[3][3], c[4] = {0, 0, 0, 0};
  for (int j = 0; j < 3; j++) {
    double most = 0;
    for (int i = 0; i < 3; i++)
      most = pktrt__max(most, pktrt__max(fabs((double)k0[4 * i + j]), fabs((double)k1[4 * i + j])));
    if (!(most > 0)) return 0;
    for (int i = 0; i < 3; i++) a[i][j] = (double)k0[4 * i + j] / most, b[i][j] = (double)k1[4 * i + j] / most;
  }
  c[0] = pktrt__place_det(a, b, 3), c[3] = pktrt__place_det(b, a, 3);
  for (int i = 0; i < 3; i++) c[1] += pktrt__place_det(a, b, i) / 3, c[2] += pktrt__place_det(b, a, i) / 3;
  const double sign = c[0] < 0 ? -1 : 1;
  return pktrt__min(pktrt__min(sign * c[0], sign * c[1]), pktrt__min(sign * c[2], sign * c[3]));
}
/* Computes kappa of an instance at rest. */
static double pktrt__place_kappa(const float *key) {
  pktrt__place p;
  double kappa = 0;
  pktrt__place_mix(key, key, 1, 0, false, &p), pktrt__place_invert(&p);
  for (int i = 0; i < 3; i++) {
    double sum = 0;
    for (int j = 0; j < 9; j++) sum += fabs(p.a[i][j / 3]) * fabs(p.inverse[j % 3][j / 3]);
    kappa = pktrt__max(kappa, sum);
  }
  return kappa;
}

/* Extends intervals by the boxes of a node's children in `lanes`, as a matrix turns them. */
static void pktrt__place_extend(const float *plane, uint32_t lanes, const float *key, double lo[3], double hi[3]) {
  for (int i = 0; i < 3; i++) {
    double middle[8] = {0, 0, 0, 0, 0, 0, 0, 0}, half[8] = {0, 0, 0, 0, 0, 0, 0, 0};
    for (int j = 0; j < 3; j++) {
      const double a = 0.5 * (double)key[4 * i + j], size = fabs(a);
      for (int c = 0; c < 8; c++) {
        const double from = (double)plane[16 * j + c], to = (double)plane[16 * j + 8 + c];
        middle[c] += a * (from + to), half[c] += size * (to - from);
      }
    }
    for (uint32_t m = lanes; m; m &= m - 1) {
      const uint32_t c = pktrt__lowest_bit(m);
      lo[i] = pktrt__min(lo[i], middle[c] - half[c]), hi[i] = pktrt__max(hi[i], middle[c] + half[c]);
    }
  }
}
/* Computes how far a model reaches along the axes, turned by a matrix: by the boxes of two levels of its trees. WHY: turned
   as a whole, the box of something round takes in twice as many rays. */
static void pktrt__place_reach(const pktrt_scene *model, const float *key, double lo[3], double hi[3]) {
  for (int i = 0; i < 3; i++) lo[i] = DBL_MAX, hi[i] = -DBL_MAX;
  for (uint32_t t = 0; t < model->bvh_count; t++)
    for (uint32_t k = 0; k < model->bvhs[t].key_count; k++) {
      const pktrt__bvh *bvh = &model->bvhs[t];
      pktrt__node *root = pktrt__bvh_node(bvh, 0), *node;
      for (uint32_t c = 0; c < 8; c++) {
        uint32_t lanes = 0;
        if (root->child[c] == PKTRT__EMPTY) continue;
        node = root->child[c] & PKTRT__LEAF ? root : pktrt__bvh_node(bvh, root->child[c]);
        for (uint32_t i = 0; i < 8; i++) lanes |= (uint32_t)(node->child[i] != PKTRT__EMPTY) << i;
        pktrt__place_extend(pktrt__node_planes(node, k), node == root ? 1u << c : lanes, key, lo, hi);
      }
    }
}

/* Computes the corners of an instance's box at a key, and a third one beside their line. */
PKTRT__COLD bool pktrt__place_box(const pktrt_scene *model, const float *key, double kappa, float box[9]) {
  double lo[3], hi[3], mu[3], most = 0;
  pktrt__place_reach(model, key, lo, hi);
  for (int i = 0; i < 3; i++) {
    mu[i] = 0;
    if (lo[i] > hi[i]) lo[i] = hi[i] = 0; /* without triangles, a point */
    for (int j = 0; j < 3 && model->lo[0] <= model->hi[0]; j++)
      mu[i] += fabs((double)key[4 * i + j]) * (double)pktrt__maxf(fabsf(model->lo[j]), fabsf(model->hi[j]));
    most = pktrt__max(most, mu[i]);
  }
  for (int i = 0; i < 3; i++) {
    const double shift = (double)key[4 * i + 3], size = fabs(shift) + mu[i];
    const double middle = shift + 0.5 * (lo[i] + hi[i]), half = 0.5 * (hi[i] - lo[i]);
    const double wide = half + PKTRT__EPS * (3 * kappa * most + 3 * mu[i] + 2 * (fabs(middle) + half)) +
                        size * 8.8817841970012523e-16 + (double)FLT_MIN; /* 2^-50 */
    if (!(fabs(middle) + wide <= (double)PKTRT_MAX_COORD)) return false;
    box[i] = (float)(middle - wide), box[3 + i] = (float)(middle + wide);
  }
  pktrt__top_box(box);
  return true;
}

/* Checks transforms of an instance, all keys of them, and finds kappa. */
PKTRT__COLD pktrt_status pktrt__instance_check(pktrt_scene *s, pktrt__instance *in, const float *keys, unsigned index) {
  float box[9];
  for (uint32_t i = 0; i < in->key_count * 12; i++)
    if (!(fabsf(keys[i]) <= PKTRT_MAX_COORD))
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "instance %u, key %u: element %u of its transform is %g, beyond %g",
                         index, (unsigned)i / 12, (unsigned)i % 12, (double)keys[i], (double)PKTRT_MAX_COORD);
  in->kappa = 0;
  for (uint32_t i = 0; i + 1 < in->key_count || !i; i++) {
    const float *k0 = keys + 12 * (size_t)i, *k1 = in->key_count > 1 ? k0 + 12 : k0;
    const double least = pktrt__place_least_det(k0, k1);
    if (!(least > PKTRT__PLACE_FLAT) && in->key_count > 1)
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT,
                         "instance %u: between keys %u and %u its transform may flatten it; give it more keys between",
                         index, (unsigned)i, (unsigned)i + 1);
    if (!(least > PKTRT__PLACE_FLAT))
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "instance %u: its transform flattens it", index);
    in->kappa = pktrt__max(in->kappa, in->key_count > 1 ? 18 / least : pktrt__place_kappa(keys));
  }
  for (uint32_t i = 0; i < in->key_count; i++)
    if (!pktrt__place_box(in->model, keys + 12 * (size_t)i, in->kappa, box))
      return pktrt__fail(s, PKTRT_LIMIT, "instance %u, key %u: it reaches beyond the limit of %g", index, (unsigned)i,
                         (double)PKTRT_MAX_COORD);
  return PKTRT_OK;
}

/* Adds the meshes that stand for those of the model, or puts them where such were. */
PKTRT__COLD bool pktrt__instance_add_meshes(pktrt_scene *s, const pktrt__instance *in, uint32_t index) {
  const uint32_t count = s->mesh_count;
  for (uint32_t i = 0; i < in->model->mesh_count; i++) {
    pktrt__mesh m;
    void *meshes = s->meshes;
    if (!pktrt__mem_grow(&s->desc, &meshes, s->mesh_count, &s->mesh_capacity, sizeof *s->meshes)) {
      s->mesh_count = count;
      return false;
    }
    memset(&m, 0, sizeof m);
    m.triangle_count = in->model->meshes[i].triangle_count, m.material = in->model->meshes[i].material;
    m.first_id = in->first_id + in->model->meshes[i].first_id, m.instance = index + 1, m.set = PKTRT_NONE;
    s->meshes = PKTRT__CAST(pktrt__mesh *, meshes), s->meshes[in->first_mesh + i] = m;
    if (in->first_mesh + i == s->mesh_count) s->mesh_count++;
  }
  return true;
}

/* Makes room for one more instance, in the scene of boxes too, and for its transforms. */
PKTRT__COLD bool pktrt__instance_make_room(pktrt_scene *s, pktrt__instance *in) {
  void *instances = s->instances;
  if (!s->boxes) s->boxes = pktrt__top_create(s);
  if (!s->boxes || !pktrt__mem_grow(&s->desc, &instances, s->instance_count, &s->instance_capacity, sizeof *in))
    return false;
  s->instances = PKTRT__CAST(pktrt__instance *, instances);
  in->keys = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, in->key_count, 12 * sizeof(float)));
  return in->keys != NULL;
}

/* Adds an instance whose transforms are in place. */
PKTRT__COLD pktrt_status pktrt__instance_add(pktrt_scene *s, pktrt__instance *in, uint32_t index) {
  const pktrt_status st = pktrt__instance_check(s, in, in->keys, (unsigned)index);
  if (st != PKTRT_OK) return st;
  pktrt_mesh_desc box;
  float(*boxes)[9] = PKTRT__CAST(float(*)[9], pktrt__mem_alloc(&s->desc, in->key_count, sizeof *boxes));
  memset(&box, 0, sizeof box);
  for (uint32_t k = 0; boxes && k < in->key_count; k++)
    (void)pktrt__place_box(in->model, in->keys + 12 * (size_t)k, in->kappa, boxes[k]);
  box.positions = boxes ? boxes[0] : NULL, box.vertex_count = 3, box.triangle_count = 1, box.key_count = in->key_count;
  const bool added = boxes && pktrt__instance_add_meshes(s, in, index);
  const bool done = added && !pktrt__mesh_add(s->boxes, &box, index);
  pktrt__mem_release(&s->desc, boxes, in->key_count, sizeof *boxes);
  if (!done) {
    for (uint32_t i = 0; added && i < in->model->mesh_count; i++) pktrt__mesh_clear(s, &s->meshes[in->first_mesh + i]);
    if (index == s->instance_count) s->mesh_count = in->first_mesh;
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "instance %u: no memory", (unsigned)index);
  }
  pktrt__place_rest(in);
  if (index == s->instance_count) s->instance_count++, s->total_triangles += in->model->total_triangles;
  else s->free_instances--;
  s->instances[index] = *in;
  return PKTRT_OK;
}

/* Finds an index for an instance: the first that waits for one of its model, or the next. */
PKTRT__COLD uint32_t pktrt__instance_find_index(const pktrt_scene *s, const pktrt_instance_desc *d) {
  uint32_t i = s->free_instances && d && d->model < s->model_count ? 0 : s->instance_count;
  while (i < s->instance_count && !(s->instances[i].free && s->instances[i].model == s->models[d->model])) i++;
  return i;
}

PKTRT_DEF pktrt_status pktrt_add_instance(pktrt_scene *s, const pktrt_instance_desc *d, uint32_t *instance) {
  static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  const uint32_t index = pktrt__instance_find_index(s, d);
  const unsigned i = (unsigned)index;
  if (!d) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "instance %u: the description is NULL", i);
  if (!PKTRT__GROUPS && d->mask)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "instance %u has a mask, but this build has PKTRT_NO_GROUPS", i);
  if (d->model >= s->model_count)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "instance %u: there is no model %u among %u", i, (unsigned)d->model,
                       (unsigned)s->model_count);
  if (d->key_count > (PKTRT__MOTION ? PKTRT_MAX_KEYS : 1))
    return pktrt__fail(s, PKTRT_LIMIT, "instance %u: key_count %u is above %u", i, (unsigned)d->key_count,
                       PKTRT__MOTION ? PKTRT_MAX_KEYS : 1);
  pktrt__instance in;
  memset(&in, 0, sizeof in);
  in.model = s->models[d->model], in.key_count = d->key_count ? d->key_count : 1;
  in.mask = d->mask ? d->mask : UINT32_MAX;
  in.first_mesh = s->mesh_count, in.first_id = s->total_triangles;
  if (index < s->instance_count)
    in.first_mesh = s->instances[index].first_mesh, in.first_id = s->instances[index].first_id;
  if (in.model->total_triangles > PKTRT_MAX_TRIANGLES - s->total_triangles)
    return pktrt__fail(s, PKTRT_LIMIT, "instance %u: %u triangles more than the %u of the scene pass %u", i,
                       (unsigned)in.model->total_triangles, (unsigned)s->total_triangles, PKTRT_MAX_TRIANGLES);
  if (!pktrt__instance_make_room(s, &in)) return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "instance %u: no memory", i);
  for (uint32_t k = 0; k < in.key_count; k++)
    memcpy(in.keys + 12 * (size_t)k, d->transforms ? d->transforms + 12 * (size_t)k : identity, 12 * sizeof(float));
  const pktrt_status st = pktrt__instance_add(s, &in, index);
  if (st != PKTRT_OK) pktrt__instance_free(s, &in);
  else if (instance) *instance = index;
  return st;
}

PKTRT_DEF pktrt_status pktrt_set_transform(pktrt_scene *s, uint32_t instance, uint32_t key, const float *transform) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  const unsigned i = (unsigned)instance;
  pktrt__instance *in = pktrt__instance_named(s, instance, "set_transform");
  if (!in) return PKTRT_INVALID_ARGUMENT;
  pktrt__instance changed = *in;
  if (key >= in->key_count || !transform)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "set_transform: instance %u, key %u: %s", i, (unsigned)key,
                       transform ? "there is no such key" : "the array is NULL");
  if (!in->pending) in->pending = PKTRT__CAST(float *, pktrt__mem_alloc(&s->desc, in->key_count, 12 * sizeof(float)));
  if (!in->pending) return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "set_transform: instance %u: no memory", i);
  if (!in->dirty) memcpy(in->pending, in->keys, in->key_count * 12 * sizeof(float));
  float before[12], box[9], *at = in->pending + 12 * (size_t)key;
  memcpy(before, at, sizeof before), memcpy(at, transform, sizeof before);
  pktrt_status st = pktrt__instance_check(s, &changed, in->pending, i);
  for (uint32_t k = 0; k < in->key_count && st == PKTRT_OK; k++) { /* without memory, the first fails */
    (void)pktrt__place_box(in->model, in->pending + 12 * (size_t)k, changed.kappa, box);
    st = pktrt_set_positions(s->boxes, instance, k, box);
    if (st != PKTRT_OK) pktrt__fail(s, st, "set_transform: instance %u: no memory", i);
  }
  if (st != PKTRT_OK) memcpy(at, before, sizeof before);
  else in->dirty = true, in->kappa = pktrt__max(in->kappa, changed.kappa);
  return st;
}

PKTRT_DEF bool pktrt_get_mesh_source(const pktrt_scene *s, uint32_t mesh, uint32_t *instance, uint32_t *model_mesh) {
  if (!s || mesh >= s->mesh_count || !s->meshes[mesh].instance) return false;
  const uint32_t index = s->meshes[mesh].instance - 1;
  if (instance) *instance = index;
  if (model_mesh) *model_mesh = mesh - s->instances[index].first_mesh;
  return true;
}
#endif

/* Returns the mesh that has the arrays: of an instance that of its model. */
static const pktrt__mesh *pktrt__mesh_source(const pktrt_scene *s, uint32_t mesh) {
  const pktrt__mesh *m = &s->meshes[mesh];
  if (!PKTRT__INSTANCES || !m->instance) return m;
  const pktrt__instance *in = &s->instances[m->instance - 1];
  return &in->model->meshes[mesh - in->first_mesh];
}

/* Finds the features that a mesh has, or where there is none any more. */
PKTRT__COLD uint32_t pktrt__feature_of_mesh(const pktrt_scene *s, uint32_t mesh) {
  const pktrt__mesh *m = &s->meshes[mesh];
  uint32_t found = m->free || m->hidden ? PKTRT_FEATURE_REMOVAL : 0;
  if (!m->triangle_count) return found;
  const pktrt__mesh *source = pktrt__mesh_source(s, mesh);
  const pktrt__instance *in = m->instance ? &s->instances[m->instance - 1] : NULL;
  const pktrt__set *set = &(in ? in->model : s)->sets[source->set];
  if (in) found |= PKTRT_FEATURE_INSTANCES;
  if (set->group || set->mask != UINT32_MAX || (in && in->mask != UINT32_MAX)) found |= PKTRT_FEATURE_GROUPS;
  if (source->key_count > 1 || (in && in->key_count > 1)) found |= PKTRT_FEATURE_MOTION;
  if (source->normals) found |= PKTRT_FEATURE_NORMALS;
  if (source->texcoords) found |= PKTRT_FEATURE_SURFACES;
  return found;
}

PKTRT__COLD void pktrt__report_info(const pktrt_scene *s, pktrt_scene_info *info) {
  memset(info, 0, sizeof *info);
  if (!s) return;
  info->isa = s->isa;
  info->mesh_count = s->committed_meshes;
  info->rebuild_advised = s->rebuild_advised;
  memcpy(info->bounds_lo, s->lo, sizeof s->lo);
  memcpy(info->bounds_hi, s->hi, sizeof s->hi);
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    const uint64_t arrays = 1u + (m->normals != NULL) + (m->pending != NULL) + (m->pending_normals != NULL);
    info->mesh_bytes += arrays * pktrt__mesh_floats(m) * sizeof(float);
    if (m->indices) info->mesh_bytes += (uint64_t)m->triangle_count * 3 * sizeof(uint32_t);
    if (m->texcoords) info->mesh_bytes += (uint64_t)m->vertex_count * 2 * sizeof(float);
    if (m->committed && (pktrt__feature_of_mesh(s, i) & PKTRT_FEATURE_MOTION)) info->moving_meshes++;
  }
  double area = 0;
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const pktrt__bvh *bvh = &s->bvhs[i];
    info->triangles += bvh->triangle_count;
    info->degenerate += bvh->degenerate_count;
    info->nodes += bvh->node_count;
    info->leaf_blocks += bvh->block_count;
    info->tree_bytes += (uint64_t)bvh->node_count * bvh->node_bytes + (uint64_t)bvh->block_count * bvh->block_bytes;
    const double weight = bvh->area > 0 ? bvh->area : 1e-300;
    info->sah_at_build += weight * bvh->sah_at_build;
    info->sah_now += weight * bvh->sah_now;
    area += weight;
  }
  if (area > 0) info->sah_at_build /= area, info->sah_now /= area;
  for (uint32_t i = 0; i < s->model_count + 2; i++) { /* each model once, then the trees above others */
    pktrt_scene_info of;
    pktrt__report_info(i < s->model_count ? s->models[i] : i == s->model_count ? s->boxes : s->groups, &of);
    info->nodes += of.nodes, info->leaf_blocks += of.leaf_blocks, info->tree_bytes += of.tree_bytes;
    info->mesh_bytes += of.mesh_bytes;
    if (i < s->model_count) info->triangles += of.triangles, info->degenerate += of.degenerate;
  }
  for (uint32_t i = 0; i < s->instance_count; i++) info->instance_count += s->boxes->meshes[i].committed;
}

PKTRT_DEF void pktrt_get_scene_info(const pktrt_scene *s, pktrt_scene_info *info) { pktrt__report_info(s, info); }

#ifndef PKTRT_NO_RENDER
/* Refuses components of a vector that are not finite, or outside [lo, hi]. */
PKTRT__COLD pktrt_status pktrt__check_range(pktrt_scene *s, const char *whose, unsigned index, const char *what,
                                            const float *v, int n, float lo, float hi) {
  for (int a = 0; a < n; a++)
    if (!(v[a] >= lo && v[a] <= hi))
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "%s %u: component %d of its %s is %g, outside [%g, %g]", whose,
                         index, a, what, (double)v[a], (double)lo, (double)hi);
  return PKTRT_OK;
}

PKTRT__COLD pktrt_status pktrt__light_check(pktrt_scene *s, const pktrt_light *l, unsigned index) {
  const float most = PKTRT_MAX_COORD;
  if (!l) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "light %u: the description is NULL", index);
  if ((int)l->kind < 0 || l->kind >= PKTRT_LIGHT_KIND_COUNT)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "light %u: %d is no kind of light", index, (int)l->kind);
  if (!PKTRT__AREA_LIGHTS && pktrt__light_has(l, PKTRT__LIGHT_AREA))
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "light %u: it has an area, but this build has PKTRT_NO_AREA_LIGHTS",
                       index);
  pktrt_status st = pktrt__check_range(s, "light", index, "intensity", l->intensity, 3, 0, FLT_MAX);
  if (!st && pktrt__light_has(l, PKTRT__LIGHT_PLACED))
    st = pktrt__check_range(s, "light", index, "position", l->position, 3, -most, most);
  if (!st && pktrt__light_has(l, PKTRT__LIGHT_ROUND))
    st = pktrt__check_range(s, "light", index, "radius", &l->radius, 1, 0, most);
  for (int e = 0; !st && e < 2 && pktrt__light_has(l, PKTRT__LIGHT_EDGED); e++)
    st = pktrt__check_range(s, "light", index, e ? "edge[1]" : "edge[0]", l->edge[e], 3, -most, most);
  if (st || !pktrt__light_has(l, PKTRT__LIGHT_DIRECTED)) return st;
  st = pktrt__check_range(s, "light", index, "direction", l->direction, 3, -most, most);
  if (!st && l->direction[0] == 0 && l->direction[1] == 0 && l->direction[2] == 0)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "light %u: its direction is zero", index);
  return st;
}

PKTRT_DEF pktrt_status pktrt_add_light(pktrt_scene *s, const pktrt_light *l, uint32_t *light) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  const pktrt_status st = pktrt__light_check(s, l, (unsigned)s->light_count);
  if (st != PKTRT_OK) return st;
  void *lights = s->lights;
  if (!pktrt__mem_grow(&s->desc, &lights, s->light_count, &s->light_capacity, sizeof *s->lights))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "light %u: no memory", (unsigned)s->light_count);
  s->lights = PKTRT__CAST(pktrt_light *, lights);
  s->lights[s->light_count] = *l;
  if (light) *light = s->light_count;
  s->light_count++;
  return PKTRT_OK;
}

PKTRT__COLD pktrt_status pktrt__material_check(pktrt_scene *s, const pktrt_material *m, unsigned index) {
  static const char *const whose = "material";
  if (!m) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "material %u: the description is NULL", index);
  if ((int)m->specular < 0 || m->specular >= PKTRT_SPECULAR_COUNT)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "material %u: %d is no pktrt_specular", index, (int)m->specular);
  if ((int)m->lobe < 0 || m->lobe > PKTRT_LOBE_PHONG)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "material %u: %d is no pktrt_lobe", index, (int)m->lobe);
  const char *missing = !PKTRT__DIELECTRIC && m->specular == PKTRT_SPECULAR_DIELECTRIC ? "DIELECTRIC"
                        : !PKTRT__CONDUCTOR && m->specular == PKTRT_SPECULAR_CONDUCTOR ? "CONDUCTOR"
                        : !PKTRT__GLOSS && pktrt__material_has_lobe(m)                 ? "GLOSS"
                        : !PKTRT__TEXTURES && (m->texture || m->shader)                ? "TEXTURES"
                        : !PKTRT__SURFACES && m->cutout                                ? "SURFACES"
                                                                                       : NULL;
  if (missing)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "material %u asks for what this build leaves out by PKTRT_NO_%s",
                       index, missing);
  if (m->cutout && !m->texture)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "material %u is a cutout, but has no texture to tell where", index);
  pktrt_status st = pktrt__check_range(s, whose, index, "albedo", m->albedo, 3, 0, 1);
  if (!st) st = pktrt__check_range(s, whose, index, "reflectance", m->reflectance, 3, 0, 1);
  if (!st) st = pktrt__check_range(s, whose, index, "ior", m->ior, 3, 0, 1e6f);
  if (!st) st = pktrt__check_range(s, whose, index, "extinction", m->extinction, 3, 0, 1e6f);
  if (!st) st = pktrt__check_range(s, whose, index, "absorption", m->absorption, 3, 0, FLT_MAX);
  if (!st) st = pktrt__check_range(s, whose, index, "exponent", &m->exponent, 1, 0, 1e9f);
  if (!st) st = pktrt__check_range(s, whose, index, "emission", m->emission, 3, 0, FLT_MAX);
  for (int a = 0; !st && a < 3 && pktrt__specular_rows[m->specular].takes; a++)
    if (m->albedo[a] + m->reflectance[a] > 1.00001f)
      return pktrt__fail(s, PKTRT_INVALID_ARGUMENT,
                         "material %u: component %d of albedo (%g) and of reflectance (%g) are more than 1 together",
                         index, a, (double)m->albedo[a], (double)m->reflectance[a]);
  return st;
}

PKTRT_DEF pktrt_status pktrt_add_material(pktrt_scene *s, const pktrt_material *m, uint32_t *material) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  const unsigned index = (unsigned)s->material_count + 1;
  const pktrt_status st = pktrt__material_check(s, m, index);
  if (st != PKTRT_OK) return st;
  void *materials = s->materials;
  if (!pktrt__mem_grow(&s->desc, &materials, s->material_count, &s->material_capacity, sizeof *s->materials))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "material %u: no memory", index);
  s->materials = PKTRT__CAST(pktrt_material *, materials);
  s->materials[s->material_count++] = *m;
  if (material) *material = s->material_count;
  return PKTRT_OK;
}

#endif /* PKTRT_NO_RENDER */

/* >>queries -------------------------------------------------------------------------------------------------------- */

/* The caller's arrays, NULL if not used. */
typedef struct pktrt__query_arrays {
  const pktrt_ray *rays;
  const pktrt_rays *ray_rows;
  pktrt_hit *hits;
  const pktrt_hits *hit_rows;
  bool *occluded;
} pktrt__query_arrays;

/* The caller's rays that a batch has: n of the `left` ones from the first on, or in an order from there. */
typedef struct pktrt__query_part {
  size_t first, left;
  const uint16_t *order; /* NULL: none */
  uint32_t n;
  const float *row[3]; /* tmin, tmax, time; NULL: rays have the value instead */
  float instead[3];
} pktrt__query_part;

/* Finds these rows of n rays. WHY a row of equal values is not used if there is an order: loading it takes longer. */
static void pktrt__query_find_rows(const pktrt_rays *rays, size_t n, pktrt__query_part *p) {
  const float *const row[3] = {rays->tmin, rays->tmax, rays->time}, none[3] = {0, INFINITY, 0};
  for (int i = 0; i < 3; i++) {
    const float *at = row[i] ? row[i] + p->first : NULL;
    const bool equal = at && p->order && !memcmp(at, at + 1, (n - 1) * sizeof *at);
    p->row[i] = equal ? NULL : row[i], p->instead[i] = equal ? *at : none[i];
  }
}

/* Prefetches a row of the caller's a batch ahead: the hardware's prefetching ends with each page. */
PKTRT__INLINE void pktrt__query_prefetch_row(const float *row, const pktrt__query_part *p) {
  const size_t line = 64 / sizeof *row;
  for (size_t i = PKTRT__BATCH; i < PKTRT__BATCH + p->n && i < p->left; i += line) PKTRT__PREFETCH(row + p->first + i);
}

/* Fills one row of a batch from the caller's, or with `instead` if there is none. */
static void pktrt__query_load_row(const pktrt_scene *s, float *row, const float *from, float instead,
                                  const pktrt__query_part *p) {
  const uint16_t *order = p->order;
  const uint32_t n = p->n;
  if (!from) {
    for (uint32_t i = 0; i < n; i++) row[i] = instead;
  } else if (order) {
    for (uint32_t i = 0; i < n; i++) row[i] = from[p->first + order[i]];
  } else {
    s->kernels->copy_row(row, from + p->first, n), pktrt__query_prefetch_row(from, p);
  }
}
static void pktrt__query_load_soa(const pktrt_scene *s, pktrt__batch *b, const pktrt_rays *rays,
                                  const pktrt__query_part *p) {
  float *const row[3] = {b->tmin, b->tmax, b->time};
  for (int i = 0; i < 3; i++) {
    pktrt__query_load_row(s, b->o[i], rays->origin[i], 0, p);
    pktrt__query_load_row(s, b->d[i], rays->direction[i], 0, p);
    pktrt__query_load_row(s, row[i], p->row[i], p->instead[i], p);
  }
}

/* Stores one row of a batch to the caller's, if there is one. */
static void pktrt__query_store_row(const pktrt_scene *s, float *to, const float *row, const pktrt__query_part *p) {
  const uint16_t *order = p->order;
  const uint32_t n = to ? p->n : 0;
  if (order) {
    for (uint32_t i = 0; i < n; i++) to[p->first + order[i]] = row[i];
  } else if (to) {
    s->kernels->copy_row(to + p->first, row, n), pktrt__query_prefetch_row(to, p);
  }
}
static void pktrt__query_store_names(const pktrt_scene *s, pktrt__batch *b, const pktrt_hits *hits,
                                     const pktrt__query_part *p) {
  uint32_t *mesh = hits->mesh ? hits->mesh + p->first : NULL;
  uint32_t *triangle = hits->triangle ? hits->triangle + p->first : NULL;
  const uint16_t *order = p->order;
  if (mesh || triangle) /* in order by rows that are needed no more */
    s->kernels->store_names(s, b, order ? b->slot : mesh, order ? b->bvh : triangle, p->n);
  for (uint32_t i = 0; order && mesh && i < p->n; i++) mesh[order[i]] = b->slot[i];
  for (uint32_t i = 0; order && triangle && i < p->n; i++) triangle[order[i]] = b->bvh[i];
}
static void pktrt__query_store_soa(const pktrt_scene *s, pktrt__batch *b, const pktrt_hits *hits,
                                   const pktrt__query_part *p) {
  pktrt__query_store_row(s, hits->t, b->t, p);
  pktrt__query_store_row(s, hits->u, b->as.hit.u, p);
  pktrt__query_store_row(s, hits->v, b->as.hit.v, p);
  for (int i = 0; i < 3; i++) pktrt__query_store_row(s, hits->normal[i], b->as.hit.normal[i], p);
  pktrt__query_store_names(s, b, hits, p);
}

/* Makes a query whose values are all in range. */
static pktrt__query pktrt__query_make(const pktrt_scene *s, const pktrt_query_desc *from, pktrt_query_desc *d,
                                      bool occlusion) {
  memset(d, 0, sizeof *d);
  if (from) *d = *from;
  if ((int)d->path < 0 || d->path > PKTRT_PATH_SINGLE) d->path = PKTRT_PATH_FAST;
  if (!PKTRT__PAPER && d->path == PKTRT_PATH_PAPER) d->path = PKTRT_PATH_FAST;
  if ((int)d->type < 0 || d->type >= PKTRT_RAY_TYPE_COUNT) d->type = PKTRT_RAY_PRIMARY;
  if (!d->mask) d->mask = UINT32_MAX;
  if (!d->packet_size || d->packet_size > PKTRT__BATCH) d->packet_size = 64;
  if (!d->paper_steps) d->paper_steps = UINT32_MAX;
  if (d->path != PKTRT_PATH_PAPER) d->trace = NULL;
  pktrt__query call;
  call.scene = s;
  call.desc = d;
  call.counts = PKTRT__STATS && d->stats ? &d->stats->by_type[d->type] : NULL;
  call.occlusion = occlusion;
  call.next = NULL, call.place = NULL, call.first = 0;
  return call;
}

enum { PKTRT__FIRST_SPARE = PKTRT__BATCH - PKTRT__SPARE };

/* Answers more rays of a batch than leave lanes for instances: the last ones when others' lanes have been put aside. */
PKTRT__COLD void pktrt__query_trace_split(const pktrt__query *call, pktrt__batch *b, uint32_t n) {
  float(*const normal)[PKTRT__ROW] = b->as.hit.normal, *const u = b->as.hit.u, *const v = b->as.hit.v;
  void *const row[] = {b->o[0], b->o[1], b->o[2], b->d[0],  b->d[1], b->d[2], b->tmin,   b->tmax,   b->time,  b->id,
                       b->slot, b->bvh,  b->t,    b->place, u,       v,       normal[0], normal[1], normal[2]};
  const size_t rows = sizeof row / sizeof *row, size = PKTRT__SPARE * sizeof(float);
  float last[sizeof row / sizeof *row][PKTRT__SPARE], first[sizeof row / sizeof *row][PKTRT__SPARE];
  for (size_t i = 0; i < rows; i++) memcpy(last[i], PKTRT__CAST(float *, row[i]) + PKTRT__FIRST_SPARE, size);
  b->spare = PKTRT__FIRST_SPARE;
  call->scene->kernels->trace(call, b, 0, PKTRT__FIRST_SPARE);
  for (size_t i = 0; i < rows; i++) {
    memcpy(first[i], row[i], size);
    memcpy(PKTRT__CAST(float *, row[i]) + PKTRT__FIRST_SPARE, last[i], size);
  }
  b->spare = 0;
  call->scene->kernels->trace(call, b, PKTRT__FIRST_SPARE, n);
  for (size_t i = 0; i < rows; i++) memcpy(row[i], first[i], size);
}
/* Answers the first n rays of a batch. */
static void pktrt__query_trace(const pktrt__query *call, pktrt__batch *b, uint32_t n) {
  b->spare = PKTRT__FIRST_SPARE;
  if (n > PKTRT__FIRST_SPARE && pktrt__has_instances(call->scene)) pktrt__query_trace_split(call, b, n);
  else call->scene->kernels->trace(call, b, 0, n);
}

/* How many incoherent rays are sorted at a time, by octant and main axis; fewer in scenes with instances, where the
   stack is for two walks. WHY: of 256 there are too few of an octant. On a Zen 5 mirror and diffuse rays gain 6 to 7%
   at rest, 12 to 14% moving. Any hit gains nothing. */
enum { PKTRT__SORTED = 4096, PKTRT__SORTED_PLACED = 1024 };

/* Prefetches what will be asked for later and not in the order of its addresses: the place of the hit of the ray `at`,
   the i-th of those that are sorted; of 16 rays that are rows those places, and all but directions. WHY in line: gcc
   drops calls of functions that only prefetch. */
PKTRT__INLINE void pktrt__query_prefetch_ahead(const pktrt__query_arrays *a, size_t at, uint32_t i, const bool rows) {
  const pktrt_rays *r = a->ray_rows;
  const pktrt_hits *h = a->hit_rows;
  if (!rows && i % 2 == 0) PKTRT__PREFETCH(a->hits + at); /* two have one cache line */
  if (!rows || i % 16) return;
  const void *const row[11] = {r->origin[0], r->origin[1], r->origin[2], h->t,    h->u,       h->v,
                               h->normal[0], h->normal[1], h->normal[2], h->mesh, h->triangle};
  for (int j = 0; j < 11; j++)
    if (row[j]) PKTRT__PREFETCH(PKTRT__CAST(const float *, row[j]) + at);
}

/* Finds the order of n rays by octant and main axis, or by octant only. WHY no branches: they would be mispredicted. */
PKTRT__INLINE void pktrt__query_sort_from(const pktrt__query_arrays *a, size_t first, uint32_t n, bool octants,
                                          uint16_t *order, const bool rows) {
  const size_t step = rows ? 1 : sizeof(pktrt_ray) / sizeof(float);
  const float *d[3];
  uint8_t key[PKTRT__SORTED];
  uint32_t end[24], sum = 0;
  for (int c = 0; c < 3; c++) d[c] = rows ? a->ray_rows->direction[c] + first : a->rays[first].direction + c;
  memset(end, 0, sizeof end);
  for (uint32_t i = 0; i < n; i++) {
    const float dx = d[0][i * step], dy = d[1][i * step], dz = d[2][i * step];
    const float x = fabsf(dx), y = fabsf(dy), z = fabsf(dz);
    const uint32_t octant = pktrt__sign_bit(dx) | pktrt__sign_bit(dy) << 1 | pktrt__sign_bit(dz) << 2;
    const uint32_t third = z > pktrt__maxf(x, y), second = (y > x) & ~third;
    key[i] = (uint8_t)(3 * octant + (octants ? 0 : third << 1 | second));
    end[key[i]]++;
    pktrt__query_prefetch_ahead(a, first + i, i, rows);
  }
  for (uint32_t k = 0; k < 24; k++) sum += end[k], end[k] = sum - end[k];
  for (uint32_t i = 0; i < n; i++) order[end[key[i]]++] = (uint16_t)i;
}
PKTRT__NOINLINE void pktrt__query_sort(const pktrt__query_arrays *a, size_t first, uint32_t n, bool octants,
                                       uint16_t *order) {
  if (a->rays) pktrt__query_sort_from(a, first, n, octants, order, false);
  else pktrt__query_sort_from(a, first, n, octants, order, true);
}

/* Tells how many of `left` rays to take next: on the paper path whole packets; on the fast path one packet while rays
   are coherent, whose rows then stay in the nearest cache, else a batch, or as many as are sorted, if not 0. */
static uint32_t pktrt__query_next_count(const pktrt_query_desc *d, const pktrt__batch *b, uint32_t sorts,
                                        uint32_t batch, size_t left) {
  uint32_t n = batch;
  if (d->path == PKTRT_PATH_PAPER && d->packet_size <= n) n = n / d->packet_size * d->packet_size;
  else if (d->path == PKTRT_PATH_FAST && b->coherent) n = 64;
  else if (d->path == PKTRT_PATH_FAST && sorts) n = sorts;
  return left < n ? (uint32_t)left : n;
}

/* Answers rays in batches, `room` at a time in an order. */
PKTRT__NOINLINE void pktrt__query_run_batches(const pktrt_scene *s, const pktrt_query_desc *desc, bool occlusion,
                                              const pktrt__query_arrays *a, size_t n, uint16_t *order, uint32_t room) {
  pktrt_query_desc d;
  pktrt__query call = pktrt__query_make(s, desc, &d, occlusion);
  pktrt__batch b;
  const uint32_t batch = pktrt__has_instances(s) ? (uint32_t)PKTRT__FIRST_SPARE : (uint32_t)PKTRT__BATCH;
  b.coherent = true, b.occluder_tree = NULL;
  if (d.packet_size > batch) d.packet_size = batch;
  size_t looked = 0, hits = 0;
  for (size_t i = 0, last; i < n; i += last) {
    const bool few_hit = 2 * hits < looked; /* then axes tell little, and sorting rows gains less than it costs */
    const bool may_sort = a->hits || (a->hit_rows && !few_hit);
    last = pktrt__query_next_count(&d, &b, may_sort ? room : 0, batch, n - i);
    const bool sorts = last > batch;
    pktrt__query_part part;
    part.first = i, part.left = n - i, part.order = sorts ? order : NULL;
    if (sorts) pktrt__query_sort(a, i, (uint32_t)last, few_hit, order);
    if (!a->rays) pktrt__query_find_rows(a->ray_rows, last, &part);
    call.next = a->rays && !sorts && n - i > 2 * PKTRT__BATCH ? a->rays + i + PKTRT__BATCH : NULL;
    call.place = a->hits && !sorts ? a->hits + i : NULL, call.first = i;
    looked = hits = 0;
    for (uint32_t from = 0; from < last; from += part.n) {
      part.n = last - from < batch ? (uint32_t)last - from : batch;
      if (sorts) part.order = order + from;
      if (a->rays) s->kernels->load_rays(&b, a->rays + i, part.order, part.n);
      else pktrt__query_load_soa(s, &b, a->ray_rows, &part);
      pktrt__query_trace(&call, &b, part.n);
      if (a->hits) s->kernels->store_hits(s, &b, a->hits + i, part.order, part.n);
      else if (a->hit_rows) pktrt__query_store_soa(s, &b, a->hit_rows, &part);
      if (occlusion) s->kernels->store_occluded(&b, a->occluded + i, part.n);
      for (uint32_t k = 0; !occlusion && k < part.n; k += 8, looked++) hits += b.id[k] != PKTRT_NONE;
    }
  }
}

/* Do so with the stack that there is, without instances and with them. */
PKTRT__NOINLINE void pktrt__query_run_many(const pktrt_scene *s, const pktrt_query_desc *desc, bool occlusion,
                                           const pktrt__query_arrays *a, size_t n) {
  uint16_t sorted[PKTRT__SORTED];
  pktrt__query_run_batches(s, desc, occlusion, a, n, sorted, PKTRT__SORTED);
}
PKTRT__NOINLINE void pktrt__query_run_placed(const pktrt_scene *s, const pktrt_query_desc *desc, bool occlusion,
                                             const pktrt__query_arrays *a, size_t n) {
  uint16_t sorted[PKTRT__SORTED_PLACED];
  pktrt__query_run_batches(s, desc, occlusion, a, n, sorted, PKTRT__SORTED_PLACED);
}

/* Tells whether rays are better traced one by one: if they are few, or not many and of different octants. */
static bool pktrt__query_is_scattered(const pktrt_ray *rays, size_t n, bool occlusion) {
  if (pktrt__too_few(n, occlusion)) return true;
  for (size_t i = 1; i < n && n < 32; i++)
    for (int a = 0; a < 3; a++)
      if (pktrt__sign_bit(rays[i].direction[a]) != pktrt__sign_bit(rays[0].direction[a])) return true;
  return false;
}

static void pktrt__query_run(const pktrt_scene *s, const pktrt_query_desc *desc, bool occlusion,
                             const pktrt__query_arrays *a, size_t n) {
  if (!a->rays || (desc && (desc->stats || desc->mask || desc->path == PKTRT_PATH_PAPER)) ||
      !pktrt__query_is_scattered(a->rays, n, occlusion))
    (pktrt__has_instances(s) ? pktrt__query_run_placed : pktrt__query_run_many)(s, desc, occlusion, a, n);
  else if (occlusion)
    for (size_t i = 0; i < n; i++) a->occluded[i] = s->kernels->occluded(s, &a->rays[i]);
  else
    for (size_t i = 0; i < n; i++) s->kernels->intersect(s, &a->rays[i], PKTRT_NONE, &a->hits[i], NULL);
}

PKTRT_DEF void pktrt_intersect_ex(const pktrt_scene *s, const pktrt_query_desc *desc, const pktrt_ray *rays,
                                  pktrt_hit *hits, size_t n) {
  const pktrt__query_arrays a = {rays, NULL, hits, NULL, NULL};
  pktrt__query_run(s, desc, false, &a, n);
}
PKTRT_DEF void pktrt_occluded_ex(const pktrt_scene *s, const pktrt_query_desc *desc, const pktrt_ray *rays, bool *out,
                                 size_t n) {
  const pktrt__query_arrays a = {rays, NULL, NULL, NULL, out};
  pktrt__query_run(s, desc, true, &a, n);
}
PKTRT_DEF void pktrt_intersect_soa_ex(const pktrt_scene *s, const pktrt_query_desc *desc, const pktrt_rays *rays,
                                      const pktrt_hits *hits, size_t n) {
  const pktrt__query_arrays a = {NULL, rays, NULL, hits, NULL};
  pktrt__query_run(s, desc, false, &a, n);
}
PKTRT_DEF void pktrt_occluded_soa_ex(const pktrt_scene *s, const pktrt_query_desc *desc, const pktrt_rays *rays,
                                     bool *out, size_t n) {
  const pktrt__query_arrays a = {NULL, rays, NULL, NULL, out};
  pktrt__query_run(s, desc, true, &a, n);
}

/* Finds a tree by its number, and the scene or model that it is of. */
static const pktrt__bvh *pktrt__tree_find(const pktrt_scene *s, uint32_t tree, const pktrt_scene **of,
                                          uint32_t *model) {
  *of = s, *model = PKTRT_NONE;
  for (uint32_t i = 0; PKTRT__STATS; i++) {
    if (tree < (*of)->bvh_count) return &(*of)->bvhs[tree];
    if (i == s->model_count) break;
    tree -= (*of)->bvh_count, *of = s->models[i], *model = i;
  }
  return NULL;
}
PKTRT_DEF bool pktrt_get_tree(const pktrt_scene *s, uint32_t tree, pktrt_tree *out) {
  const pktrt_scene *of;
  memset(out, 0, sizeof *out);
  const pktrt__bvh *bvh = pktrt__tree_find(s, tree, &of, &out->model);
  if (!bvh) {
    out->model = 0;
    return false;
  }
  out->group = of->sets[bvh->set].group, out->mask = bvh->mask, out->keys = bvh->key_count;
  out->nodes = bvh->node_count, out->leaves = bvh->block_count;
  memcpy(out->lo, bvh->lo, sizeof out->lo), memcpy(out->hi, bvh->hi, sizeof out->hi);
  return true;
}

PKTRT_DEF bool pktrt_get_node(const pktrt_scene *s, uint32_t tree, uint32_t index, float time, pktrt_node *out) {
  const pktrt_scene *of;
  uint32_t model, hint[2] = {0, 0};
  float ta, tb;
  memset(out, 0, sizeof *out);
  const pktrt__bvh *bvh = pktrt__tree_find(s, tree, &of, &model);
  if (!bvh || index >= bvh->node_count) return false;
  pktrt__node *node = pktrt__bvh_node(bvh, index);
  const bool moving = pktrt__has_motion(bvh->key_count);
  const uint32_t segment = pktrt__time_segment(time, bvh->key_count, &ta, &tb), next = segment + (moving ? 1 : 0);
  const float *first = pktrt__node_planes(node, segment), *second = pktrt__node_planes(node, next);
  for (int k = 0; k < 8; k++) {
    const uint32_t child = node->child[k];
    const bool leaf = child != PKTRT__EMPTY && (child & PKTRT__LEAF);
    out->leaf[k] = leaf, out->child[k] = child == PKTRT__EMPTY ? PKTRT_NONE : child & ~PKTRT__LEAF;
    for (int plane = 0; plane < 6; plane++) { /* interpolated, it is rounded by less than 3 half units of the larger */
      const float a = first[8 * plane + k], b = second[8 * plane + k];
      const float off = moving ? 4 * PKTRT__EPS * pktrt__maxf(fabsf(a), fabsf(b)) : 0;
      const float at = moving ? ta * a + tb * b : a;
      if (plane % 2) out->hi[k][plane / 2] = at + off;
      else out->lo[k][plane / 2] = at - off;
    }
    for (int i = 0; i < 8; i++) {
      const uint32_t id = leaf ? pktrt__bvh_block(bvh, out->child[k])->id[i] : PKTRT_NONE, none = 0;
      pktrt__mesh_name_triangle(of, id, &none, hint, &out->mesh[k][i], &out->triangle[k][i]);
      out->order[k][i] = (uint8_t)(node->order[k] >> (21 - 3 * i) & 7);
    }
  }
  return true;
}

PKTRT_DEF pktrt_ray pktrt_make_ray(const float origin[3], const float direction[3]) {
  pktrt_ray ray;
  for (int a = 0; a < 3; a++) ray.origin[a] = origin[a], ray.direction[a] = direction[a];
  ray.tmin = 0, ray.tmax = INFINITY, ray.time = 0;
  return ray;
}

/* Traces one ray directly, without a batch. */
PKTRT_DEF bool pktrt_intersect(const pktrt_scene *s, const pktrt_ray *ray, pktrt_hit *hit) {
  return s->kernels->intersect(s, ray, PKTRT_NONE, hit, NULL);
}
PKTRT_DEF bool pktrt_occluded(const pktrt_scene *s, const pktrt_ray *ray) { return s->kernels->occluded(s, ray); }
PKTRT_DEF void pktrt_intersect_n(const pktrt_scene *s, const pktrt_ray *rays, pktrt_hit *hits, size_t n) {
  pktrt_intersect_ex(s, NULL, rays, hits, n);
}
PKTRT_DEF void pktrt_occluded_n(const pktrt_scene *s, const pktrt_ray *rays, bool *out, size_t n) {
  pktrt_occluded_ex(s, NULL, rays, out, n);
}
PKTRT_DEF void pktrt_intersect_soa(const pktrt_scene *s, const pktrt_rays *rays, const pktrt_hits *hits, size_t n) {
  pktrt_intersect_soa_ex(s, NULL, rays, hits, n);
}
PKTRT_DEF void pktrt_occluded_soa(const pktrt_scene *s, const pktrt_rays *rays, bool *out, size_t n) {
  pktrt_occluded_soa_ex(s, NULL, rays, out, n);
}

/* >>spawn ----------------------------------------------------------------------------------------------------------

   A hit is known twice: by its t, which errs by 1.4 eps |t d_a| along axis a (0.7 ulp, >>exactness), and by u and v, which
   err by 2 eps (|e1_a| + |e2_a|) with the edges e1 and e2. The point q of the surface takes the better of both in each
   axis: the second on small triangles far away, the first on large ones. What is left of the error is along the surface,
   for q is then put on the plane of the triangle, in doubles, whose rounding leaves it within

     B = max(2^-48 kappa, 2^-40) sum(|q_a| + |q_a - P_a|),  kappa = max |e1| max |e2| / max |N|,  N = e1 x e2

   of the plane: N errs by 2^-51 kappa of itself; nearer than 2^-40 doubles cannot tell that the triangle is behind.
   (Where kappa > 2^27 the normal of the hit serves, which is sharper there: B has 2^-21.) A ray that leaves to the side
   s of the unit normal n starts at the float o' next to q + s h n. Rounding costs at most eps sum |n_a q'_a| of the
   distance from the plane, so that

     h = (1 + 2^-7) (eps sum |n_a q_a| + B) + 2^-147

   leaves s n . (o' - P) > 0: with s n . d >= 0 the exact t of the triangle is negative, so is its float, and no ray meets
   the triangle it left, nor another of a convex mesh.

   In an instance (>>places) all this holds of the ray in its frame, h' there. As n . R v = g N . v, with the unit normal
   N of the scene along transpose(R) n and g its length, a way h along N is g h in the frame, and what rounding o costs
   there is g eps sum |N_a o_a|: h = h' / g + (1 + 2^-7) eps sum |N_a q_a|, and 2^-48 kappa of q and s for doubles. */

/* Computes the position or normal, from `data`, of corner c of a triangle at the ray's time. */
static void pktrt__mesh_corner_at(const pktrt__mesh *m, const float *data, uint32_t triangle, uint32_t c, float time,
                                  float out[3]) {
  const uint64_t v = m->indices ? m->indices[(size_t)triangle * 3 + c] : (uint64_t)triangle * 3 + c;
  if (!pktrt__has_motion(m->key_count)) {
    memcpy(out, data + v * 3, 3 * sizeof *out);
    return;
  }
  float ta, tb;
  const uint32_t key = pktrt__time_segment(time, m->key_count, &ta, &tb);
  const float *k0 = data + ((uint64_t)key * m->vertex_count + v) * 3, *k1 = k0 + (uint64_t)m->vertex_count * 3;
  for (int a = 0; a < 3; a++) out[a] = ta * k0[a] + tb * k1[a];
}

/* A point that rays leave: the surface's, and what it takes to start beside it. */
typedef struct pktrt__spawn_point {
  double at[3], normal[3], offset; /* along the unit normal */
} pktrt__spawn_point;

/* Finds the point of a hit, see above. */
static void pktrt__spawn_find(float p[3][3], const pktrt_ray *ray, const pktrt_hit *hit, pktrt__spawn_point *x) {
  double e[2][3], n[3], q[3], most[2] = {0, 0}, along = 0, n2 = 0, sum = 0, rounding = 0;
  for (int a = 0; a < 3; a++) {
    const double p0 = (double)p[0][a], way = (double)hit->t * (double)ray->direction[a];
    for (int i = 0; i < 2; i++) e[i][a] = (double)p[i + 1][a] - p0, most[i] = pktrt__max(most[i], fabs(e[i][a]));
    q[a] = PKTRT__ERROR_T * fabs(way) < PKTRT__ERROR_UV * (fabs(e[0][a]) + fabs(e[1][a]))
               ? ((double)ray->origin[a] + way) - p0
               : (double)hit->u * e[0][a] + (double)hit->v * e[1][a];
  }
  const bool sharp = pktrt__tri_normal(p, n);
  double plane =
      sharp ? PKTRT__ERROR_PLANE * (most[0] * most[1] / pktrt__max_abs3(n[0], n[1], n[2])) : PKTRT__ERROR_NEEDLE;
  plane = pktrt__max(plane, PKTRT__ERROR_LEAST); /* B is so much of the sum */
  for (int a = 0; a < 3; a++) n[a] = sharp ? n[a] : (double)hit->normal[a], along += n[a] * q[a], n2 += n[a] * n[a];
  const double length = sqrt(n2);
  for (int a = 0; a < 3; a++) {
    q[a] -= along / n2 * n[a], x->at[a] = (double)p[0][a] + q[a], x->normal[a] = n[a] / length;
    sum += fabs(q[a]) + fabs(x->at[a]), rounding += fabs(x->normal[a] * x->at[a]);
  }
  x->offset = 1.0078125 * (PKTRT__EPS * rounding + plane * sum) + FLT_MIN * PKTRT__ERROR_NEEDLE;
}

/* Computes the origin of a ray that leaves to a side of the normal, 1 or -1. */
static void pktrt__spawn_origin(const pktrt__spawn_point *x, int side, float origin[3]) {
  for (int a = 0; a < 3; a++) origin[a] = (float)(x->at[a] + side * x->offset * x->normal[a]);
}

/* Returns the side of a triangle that a direction leads to, exactly: along the plane it is 1. */
static int pktrt__spawn_side(float p[3][3], const pktrt__spawn_point *x, const float d[3]) {
  double along = 0, size = 0;
  for (int a = 0; a < 3; a++) along += x->normal[a] * (double)d[a], size += fabs((double)d[a]);
  if (fabs(along) > PKTRT__ERROR_NEEDLE * size) return along < 0 ? -1 : 1;
  pktrt__exact_view v;
  pktrt__exact_view_of(&v, pktrt__axes[0], d, d, 1, p[0], 1);
  return pktrt__exact_along(&v) < 0 ? -1 : 1;
}

/* Finds corners and ray in the frame of what a mesh belongs to; returns how that lies, NULL if directly in the scene. */
static const pktrt__place *pktrt__spawn_frame(const pktrt_scene *s, uint32_t mesh, uint32_t triangle,
                                              const pktrt_ray *ray, float p[3][3], pktrt_ray *within,
                                              pktrt__place *moving) {
  const pktrt__mesh *m = pktrt__mesh_source(s, mesh);
  *within = *ray;
  for (uint32_t c = 0; c < 3; c++) pktrt__mesh_corner_at(m, m->positions, triangle, c, ray->time, p[c]);
  if (!PKTRT__INSTANCES || !s->meshes[mesh].instance) return NULL;
  const pktrt__place *place = pktrt__place_at(&s->instances[s->meshes[mesh].instance - 1], ray->time, moving);
  pktrt__place_ray(place, ray->origin, ray->direction, 1, within->origin, within->direction, 1);
  return place;
}

/* Moves a point from the frame of an instance to the scene. */
PKTRT__COLD void pktrt__spawn_place(const pktrt__place *p, double kappa, pktrt__spawn_point *x) {
  double n[3], at[3], g = 0, rounding = 0, size = 0;
  const double side = pktrt__place_side(p);
  for (int a = 0; a < 3; a++) {
    const double *row = p->a[a];
    at[a] = ((row[0] * x->at[0] + row[1] * x->at[1]) + row[2] * x->at[2]) + p->shift[a];
    n[a] = (p->inverse[a][0] * x->normal[0] + p->inverse[a][1] * x->normal[1]) + p->inverse[a][2] * x->normal[2];
    g += n[a] * n[a];
  }
  g = sqrt(g);
  for (int a = 0; a < 3; a++) {
    x->at[a] = at[a], x->normal[a] = side * n[a] / g;
    rounding += fabs(x->normal[a] * at[a]), size += fabs(at[a]) + fabs(p->shift[a]);
  }
  x->offset = x->offset / g + 1.0078125 * (PKTRT__EPS * rounding + PKTRT__ERROR_PLANE * kappa * size);
}

/* Finds the point of a hit of any mesh, and the side of it that a direction leads to, if one is given. */
static int pktrt__spawn_from(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit, const float *direction,
                             pktrt__spawn_point *x) {
  float p[3][3];
  pktrt_ray within;
  pktrt_hit there = *hit;
  pktrt__place moving;
  pktrt_ray from = *ray;
  for (int a = 0; a < 3 && direction; a++) from.direction[a] = direction[a];
  const pktrt__place *place = pktrt__spawn_frame(s, hit->mesh, hit->triangle, &from, p, &within, &moving);
  if (!place) {
    pktrt__spawn_find(p, ray, hit, x);
    return direction ? pktrt__spawn_side(p, x, direction) : 1;
  }
  float along[3];
  memcpy(along, within.direction, sizeof along);
  pktrt__place_ray(place, ray->origin, ray->direction, 1, within.origin, within.direction, 1);
  for (int a = 0; a < 3; a++) /* along transpose(A) n */
    there.normal[a] = (float)(place->a[0][a] * (double)hit->normal[0] + place->a[1][a] * (double)hit->normal[1] +
                              place->a[2][a] * (double)hit->normal[2]);
  pktrt__spawn_find(p, &within, &there, x);
  const int side = direction ? pktrt__spawn_side(p, x, along) : 1;
  pktrt__spawn_place(place, s->instances[s->meshes[hit->mesh].instance - 1].kappa, x);
  return side * pktrt__place_side(place);
}

PKTRT_DEF void pktrt_spawn(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit, const float direction[3],
                           pktrt_ray *out) {
  const pktrt_ray from = *ray;
  const float d[3] = {direction[0], direction[1], direction[2]};
  memset(out, 0, sizeof *out);
  out->time = from.time;
  if (!s || hit->mesh >= s->committed_meshes || hit->triangle >= s->meshes[hit->mesh].triangle_count) return;
  pktrt__spawn_point x;
  const int side = pktrt__spawn_from(s, &from, hit, d, &x);
  pktrt__spawn_origin(&x, side, out->origin);
  memcpy(out->direction, d, sizeof d);
  out->tmax = INFINITY;
}

PKTRT_DEF void pktrt_spawn_n(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *hits,
                             const float *directions, pktrt_ray *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_spawn(s, &rays[i], &hits[i], directions + 3 * i, &out[i]);
}

/* >>crossings: all hits along a ray, not only the nearest ---------------------------------------------------------- */

/* Finds the next hit, and where it is, see pktrt__entry_intersect. */
static bool pktrt__crossing_next(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *previous, pktrt_hit *hit,
                                 uint32_t *where) {
  pktrt_ray rest = *ray;
  uint32_t after = PKTRT_NONE;
  if (previous && (previous->mesh >= s->committed_meshes || ray->tmin < previous->t)) {
    rest.tmin = previous->mesh < s->committed_meshes ? previous->t : INFINITY;
    if (rest.tmin < INFINITY) after = s->meshes[previous->mesh].first_id + previous->triangle;
  }
  return s->kernels->intersect(s, &rest, after, hit, where);
}
PKTRT_DEF bool pktrt_intersect_after(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *previous,
                                     pktrt_hit *hit) {
  return pktrt__crossing_next(s, ray, previous, hit, NULL);
}
PKTRT_DEF void pktrt_intersect_after_n(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *previous,
                                       pktrt_hit *hits, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_intersect_after(s, &rays[i], previous ? &previous[i] : NULL, &hits[i]);
}

PKTRT_DEF size_t pktrt_intersect_all(const pktrt_scene *s, const pktrt_ray *ray, pktrt_hit *hits, size_t capacity) {
  pktrt_hit at[2];
  size_t n = 0;
  for (; pktrt_intersect_after(s, ray, n ? &at[(n - 1) & 1] : NULL, &at[n & 1]); n++)
    if (n < capacity) hits[n] = at[n & 1];
  return n;
}
PKTRT_DEF void pktrt_intersect_all_n(const pktrt_scene *s, const pktrt_ray *rays, pktrt_hit *hits, size_t capacity,
                                     size_t *counts, size_t n) {
  for (size_t i = 0; i < n; i++) counts[i] = pktrt_intersect_all(s, &rays[i], hits + i * capacity, capacity);
}

/* Returns 1 where a ray leaves by the triangle it hits, the side where corners appear clockwise, or -1 where it enters. */
static int pktrt__crossing_exits(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit) {
  float p[3][3];
  double n[3], along = 0, size = 0;
  pktrt_ray within;
  pktrt__place moving;
  const pktrt__place *place = pktrt__spawn_frame(s, hit->mesh, hit->triangle, ray, p, &within, &moving);
  const bool sharp = pktrt__tri_normal(p, n);
  for (int a = 0; a < 3; a++) {
    const double d = (double)within.direction[a];
    along += n[a] * d, size += fabs(d);
  }
  if (!sharp || !(fabs(along) > size * pktrt__max_abs3(n[0], n[1], n[2]) * 9.5367431640625e-7)) { /* 2^-20 */
    pktrt__exact_view v;
    pktrt__exact_view_of(&v, pktrt__axes[0], within.origin, within.direction, 1, p[0], 1);
    along = pktrt__exact_along(&v);
  }
  return (along > 0 ? 1 : -1) * (place ? pktrt__place_side(place) : 1);
}

/* Tells of each crossing of a ray, in order: the mesh, and whether it is left or entered. */
static void pktrt__crossing_each(const pktrt_scene *s, const pktrt_ray *ray, void (*tell)(void *, uint32_t, int),
                                 void *of) {
  pktrt_hit at;
  for (bool hit = pktrt_intersect_after(s, ray, NULL, &at); hit; hit = pktrt_intersect_after(s, ray, &at, &at))
    tell(of, at.mesh, pktrt__crossing_exits(s, ray, &at));
}

typedef struct pktrt__crossing_sum {
  uint32_t mesh;
  int exits; /* minus entries */
} pktrt__crossing_sum;
static void pktrt__crossing_count(void *of, uint32_t mesh, int exits) {
  pktrt__crossing_sum *sum = PKTRT__CAST(pktrt__crossing_sum *, of);
  if (mesh == sum->mesh) sum->exits += exits;
}
PKTRT_DEF int pktrt_winding(const pktrt_scene *s, uint32_t mesh, const float point[3], float time) {
  static const float ahead[3] = {1, 0, 0};
  pktrt_ray ray = pktrt_make_ray(point, ahead);
  pktrt__crossing_sum sum = {mesh, 0};
  ray.time = time;
  pktrt__crossing_each(s, &ray, pktrt__crossing_count, &sum);
  return sum.exits;
}
PKTRT_DEF void pktrt_winding_n(const pktrt_scene *s, uint32_t mesh, const float *points, const float *times, int *out,
                               size_t n) {
  for (size_t i = 0; i < n; i++) out[i] = pktrt_winding(s, mesh, points + 3 * i, times ? times[i] : 0);
}

/* >>vectors -------------------------------------------------------------------------------------------------------- */

static double pktrt__dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

PKTRT__INLINE void pktrt__cross(const double a[3], const double b[3], double out[3]) {
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  out[0] = x, out[1] = y, out[2] = z;
}

/* Scales a vector to length 1; false for zero and for what is not finite. Its largest component is scaled to 1 first,
   as squares of tiny or huge numbers leave the range. */
static bool pktrt__normalise(double v[3]) {
  const double m = pktrt__max(fabs(v[0]), pktrt__max(fabs(v[1]), fabs(v[2])));
  if (!(m > 0 && m <= DBL_MAX)) return false;
  for (int a = 0; a < 3; a++) v[a] /= m;
  const double length = sqrt(pktrt__dot(v, v));
  for (int a = 0; a < 3; a++) v[a] /= length;
  return true;
}

/* >>shading: what one shades with --------------------------------------------------------------------------------- */

/* Computes the shading normals of a triangle of an instance: of length 1, as columns of different lengths would bend them. */
PKTRT__COLD void pktrt__surface_place_normals(const pktrt_scene *scene, uint32_t mesh, uint32_t triangle, float time,
                                              float n[3][3]) {
  const pktrt__mesh *m = pktrt__mesh_source(scene, mesh);
  pktrt__place moving;
  const pktrt__place *p = pktrt__place_at(&scene->instances[scene->meshes[mesh].instance - 1], time, &moving);
  const double side = pktrt__place_side(p);
  for (uint32_t c = 0; c < 3; c++) {
    double x[3];
    pktrt__mesh_corner_at(m, m->normals, triangle, c, time, n[c]);
    for (int a = 0; a < 3; a++)
      x[a] = side * ((p->inverse[a][0] * (double)n[c][0] + p->inverse[a][1] * (double)n[c][1]) +
                     p->inverse[a][2] * (double)n[c][2]);
    (void)pktrt__normalise(x);
    for (int a = 0; a < 3; a++) n[c][a] = (float)x[a];
  }
}

/* Interpolates the texture coordinates of a triangle; 0 where its mesh has none. */
PKTRT__NOINLINE void pktrt__texcoord_at(const pktrt_scene *s, uint32_t mesh, uint32_t triangle, float u, float v,
                                        float out[2]) {
  const pktrt__mesh *m = pktrt__mesh_source(s, mesh);
  out[0] = out[1] = 0;
  if (!PKTRT__SURFACES || !m->texcoords) return;
  const float weight[3] = {1 - u - v, u, v};
  for (uint32_t c = 0; c < 3; c++) {
    const size_t at = (size_t)triangle * 3 + c, vertex = m->indices ? m->indices[at] : at;
    for (int i = 0; i < 2; i++) out[i] += weight[c] * m->texcoords[2 * vertex + (size_t)i];
  }
}

#ifndef PKTRT_NO_SURFACES
/* Interpolates the shading normal of a hit; false where its mesh has none. */
static bool pktrt__shading_normal(const pktrt_scene *s, const pktrt_hit *hit, float time, double n[3]) {
  const pktrt__mesh *m = pktrt__mesh_source(s, hit->mesh);
  float corner[3][3];
  if (!m->normals) return false;
  if (s->meshes[hit->mesh].instance) pktrt__surface_place_normals(s, hit->mesh, hit->triangle, time, corner);
  else
    for (uint32_t c = 0; c < 3; c++) pktrt__mesh_corner_at(m, m->normals, hit->triangle, c, time, corner[c]);
  for (int a = 0; a < 3; a++) {
    const double x = (double)corner[0][a];
    n[a] = x + (double)hit->u * ((double)corner[1][a] - x) + (double)hit->v * ((double)corner[2][a] - x);
  }
  return pktrt__normalise(n);
}

PKTRT_DEF void pktrt_surface(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit,
                             pktrt_surface_info *out) {
  memset(out, 0, sizeof *out);
  out->instance = PKTRT_NONE;
  if (!s || hit->mesh >= s->committed_meshes || hit->triangle >= s->meshes[hit->mesh].triangle_count) return;
  const pktrt__mesh *m = &s->meshes[hit->mesh];
  pktrt__spawn_point x;
  double n[3], ns[3], d[3];
  (void)pktrt__spawn_from(s, ray, hit, NULL, &x);
  for (int a = 0; a < 3; a++) n[a] = (double)hit->normal[a], d[a] = (double)ray->direction[a];
  (void)pktrt__normalise(n);
  out->inside = pktrt__dot(n, d) > 0;
  for (int a = 0; a < 3; a++) ns[a] = n[a] = out->inside ? -n[a] : n[a];
  if (!pktrt__shading_normal(s, hit, ray->time, ns)) memcpy(ns, n, sizeof ns);
  const double side = pktrt__dot(n, ns) < 0 ? -1 : 1;
  for (int a = 0; a < 3; a++)
    out->position[a] = (float)x.at[a], out->normal[a] = (float)n[a], out->shading_normal[a] = (float)(side * ns[a]);
  pktrt__texcoord_at(s, hit->mesh, hit->triangle, hit->u, hit->v, out->texcoord);
  out->material = m->material;
  if (m->instance) out->instance = m->instance - 1;
}
PKTRT_DEF void pktrt_surface_n(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *hits,
                               pktrt_surface_info *out, size_t n) {
  for (size_t i = 0; i < n; i++) pktrt_surface(s, &rays[i], &hits[i], &out[i]);
}

/* Finds the normal of a triangle, as that of a hit; false where it has no area. */
static bool pktrt__spawn_normal(const pktrt_scene *s, const pktrt_ray *ray, pktrt_hit *hit) {
  float p[3][3];
  double n[3], at[3];
  pktrt_ray within;
  pktrt__place moving;
  pktrt__exact_view v;
  const pktrt__place *place = pktrt__spawn_frame(s, hit->mesh, hit->triangle, ray, p, &within, &moving);
  pktrt__exact_view_of(&v, pktrt__axes[0], within.origin, within.direction, 1, p[0], 1);
  if (!pktrt__tri_normal(p, n)) pktrt__exact_normal(v, n);
  memcpy(at, n, sizeof at);
  for (int a = 0; a < 3 && place; a++)
    at[a] = pktrt__place_side(place) *
            (place->inverse[a][0] * n[0] + place->inverse[a][1] * n[1] + place->inverse[a][2] * n[2]);
  const double most = pktrt__max_abs3(at[0], at[1], at[2]);
  for (int a = 0; a < 3 && most > 0; a++) hit->normal[a] = (float)(at[a] / most);
  return most > 0;
}
PKTRT_DEF void pktrt_spawn_at(const pktrt_scene *s, uint32_t mesh, uint32_t triangle, float u, float v, float time,
                              const float direction[3], pktrt_ray *out) {
  pktrt_ray ray = pktrt_make_ray(direction, direction);
  pktrt_hit hit;
  ray.time = time;
  hit.t = NAN, hit.u = u, hit.v = v, hit.mesh = mesh, hit.triangle = triangle; /* known by u and v alone */
  memset(out, 0, sizeof *out);
  out->time = time;
  if (!s || mesh >= s->committed_meshes || triangle >= s->meshes[mesh].triangle_count) return;
  if (pktrt__spawn_normal(s, &ray, &hit)) pktrt_spawn(s, &ray, &hit, ray.direction, out);
}
PKTRT_DEF void pktrt_spawn_at_n(const pktrt_scene *s, const pktrt_hit *hits, const float *times,
                                const float *directions, pktrt_ray *out, size_t n) {
  for (size_t i = 0; i < n; i++)
    pktrt_spawn_at(s, hits[i].mesh, hits[i].triangle, hits[i].u, hits[i].v, times ? times[i] : 0, directions + 3 * i,
                   &out[i]);
}
#endif

#ifndef PKTRT_NO_RENDER
/* >>samplers ------------------------------------------------------------------------------------------------------- */

PKTRT_DEF const char *pktrt_sampler_string(pktrt_sampler sampler) {
  if (sampler == PKTRT_SAMPLER_CUSTOM) return "custom";
  return (int)sampler >= 0 && sampler < PKTRT_SAMPLER_COUNT ? pktrt__sampler_rows[sampler].name : "no sampler";
}

/* --- the ways in which Sobol's points are dealt out, see >>random --- */

/* Spreads the bits of x to every other place, from the 0th on. */
PKTRT__INLINE uint32_t pktrt__sampler_spread_bits(uint32_t x) { /* x < 256 */
  x = (x | x << 4) & 0x0F0Fu;
  x = (x | x << 2) & 0x3333u;
  return (x | x << 1) & 0x5555u;
}

/* Returns a pixel's place on a Morton curve in 256 x 256, with quarters in random order (Ahmed and Wonka 2020). */
static uint32_t pktrt__sampler_shuffled_morton(uint32_t x, uint32_t y, uint64_t key) {
  static const uint8_t orders[24] = {0x1B, 0x1E, 0x27, 0x2D, 0x36, 0x39, 0x4B, 0x4E, 0x63, 0x6C, 0x72, 0x78,
                                     0x87, 0x8D, 0x93, 0x9C, 0xB1, 0xB4, 0xC6, 0xC9, 0xD2, 0xD8, 0xE1, 0xE4};
  const uint32_t place = pktrt__sampler_spread_bits(x & 255) | pktrt__sampler_spread_bits(y & 255) << 1;
  uint32_t out = 0;
  for (uint32_t level = 0; level < 16; level += 2) {
    const uint64_t node = (place | 0x10000u) >> level >> 2; /* the square that the quarter belongs to, as in a heap */
    const uint64_t h = (node * UINT64_C(0xD1342543DE82EF95) ^ key) * UINT64_C(0xAF251AF3B0F025B5);
    const uint32_t order = orders[pktrt__sampler_below((uint32_t)(h >> 32), 24)];
    out |= (order >> (place >> level & 3) * 2 & 3) << level;
  }
  return out;
}

/* --- grids and radical inverses --- */

/* Draws a pair of dimensions in a x b cells: a b = n with sides up to 2 : 1 if there are such; if not, the next
   rectangle, of which random cells stay empty. */
static void pktrt__sampler_jittered_pair(uint32_t sample, uint32_t samples, uint64_t key, float out[2]) {
  const uint32_t root = (uint32_t)sqrt((double)samples), least = root * root < samples ? root + 1 : root;
  uint32_t a = least;
  while (samples % a && a * a <= 2 * samples) a++;
  if (samples % a || a * a > 2 * samples) a = least;
  const uint32_t b = (samples + a - 1) / a;
  const uint32_t cell = pktrt__sampler_permute(sample, a * b, key);
  const uint64_t at = pktrt__hash(key + 2 + sample);
  out[0] = pktrt__sampler_unit_of(((double)(cell % a) + (double)(uint32_t)at * (1 / 4294967296.0)) / (double)a);
  out[1] = pktrt__sampler_unit_of(((double)(cell / a) + (double)(uint32_t)(at >> 32) * (1 / 4294967296.0)) / (double)b);
}

/* Computes the radical inverse of i < n in a prime base, scrambled in Owen's way: each digit is replaced by that of a
   permutation which depends on all digits before. The permutations are affine, d -> a d + c: any two digits go to any
   two, equally likely, and no more enters the variance. Digits beyond those that n needs are random. */
static float pktrt__sampler_radical_inverse(uint32_t i, uint32_t n, uint32_t base, uint64_t key) {
  uint32_t reach = 1, digits = 0;
  for (uint32_t rest = i; reach < n; rest /= base) {
    const uint64_t h = pktrt__hash(key + reach + i % reach); /* i % reach: the digits before */
    const uint32_t a = 1 + pktrt__sampler_below((uint32_t)(h >> 32), base - 1),
                   c = pktrt__sampler_below((uint32_t)h, base);
    digits = digits * base + (a * (rest % base) + c) % base;
    reach *= base;
  }
  const double tail = (double)pktrt__sampler_unit((uint32_t)(pktrt__hash(key + reach + i) >> 32));
  return pktrt__sampler_unit_of(((double)digits + tail) / (double)reach);
}

/* Draws one coordinate. Halton's bases are the first 32 primes; later dimensions use them again, with other scrambles,
   and with the points in another random order, so that they meet those of the first 32 at random. Hammersley's points
   have i / n before these, and every 32 dimensions again; their order is random from the start, since n is known: each
   coordinate of each sample is uniform over seeds. */
static float pktrt__sampler_halton_number(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample,
                                          uint32_t dimension) {
  static const uint8_t primes[32] = {2,  3,  5,  7,  11, 13, 17, 19, 23, 29,  31,  37,  41,  43,  47,  53,
                                     59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103, 107, 109, 113, 127, 131};
  const bool hammersley = s->sampler == PKTRT_SAMPLER_HAMMERSLEY;
  const uint32_t round = dimension / 32, k = dimension % 32;
  const uint64_t key = pktrt__sampler_key(s->seed, dimension, x, y);
  if (round || hammersley)
    sample = pktrt__sampler_permute(sample, s->samples, pktrt__sampler_key(s->seed, ~round, x, y));
  if (!hammersley) return pktrt__sampler_radical_inverse(sample, s->samples, primes[k], key);
  if (k) return pktrt__sampler_radical_inverse(sample, s->samples, primes[k - 1], key);
  const double at = (double)pktrt__sampler_unit((uint32_t)(pktrt__hash(key + sample) >> 32));
  return pktrt__sampler_unit_of(((double)sample + at) / (double)s->samples);
}

/* --- the samplers: coordinates of one group --- */

static void pktrt__sampler_sobol(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                 uint32_t n, float *out) {
  const uint64_t key = pktrt__sampler_key(s->seed, dimension / 4, x, y);
  uint32_t digits[4];
  pktrt__sampler_net(pktrt__sampler_point_index(dimension / 4, sample, s->samples, key), s->samples, digits);
  pktrt__sampler_scramble(digits, key, dimension % 4, n, out);
}

static void pktrt__sampler_random(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                  uint32_t n, float *out) {
  const uint64_t key = pktrt__sampler_key(s->seed, dimension / 4, x, y) + 2 * (uint64_t)sample;
  const uint64_t bits[2] = {pktrt__hash(key), pktrt__hash(key + 1)};
  for (uint32_t i = 0, d = dimension % 4; i < n; i++, d++)
    out[i] = pktrt__sampler_unit((uint32_t)(bits[d / 2] >> d % 2 * 32));
}
static void pktrt__sampler_jittered(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample,
                                    uint32_t dimension, uint32_t n, float *out) {
  for (uint32_t i = 0, d = dimension % 4; i < n;) {
    float pair[2];
    pktrt__sampler_jittered_pair(sample, s->samples, pktrt__sampler_key(s->seed, dimension / 4 * 2 + d / 2, x, y),
                                 pair);
    do out[i++] = pair[d++ % 2];
    while (i < n && d % 2);
  }
}
static void pktrt__sampler_halton(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                  uint32_t n, float *out) {
  for (uint32_t i = 0; i < n; i++) out[i] = pktrt__sampler_halton_number(s, x, y, sample, dimension + i);
}

/* Takes runs in Morton order: any 2 x 2 pixels hold one run of each class modulo 4. */
static void pktrt__sampler_interleaved(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample,
                                       uint32_t dimension, uint32_t n, float *out) {
  const uint64_t key = pktrt__sampler_key(s->seed, dimension / 4, 0, 0);
  const uint32_t run =
      (pktrt__sampler_spread_bits(x & 3) | pktrt__sampler_spread_bits(y & 3) << 1) ^ (uint32_t)key >> 28;
  uint32_t digits[4];
  pktrt__sampler_sequence(pktrt__sampler_run_index(run, sample, s->samples, pktrt__hash(key + 4 + run)), digits);
  pktrt__sampler_scramble(digits, key, dimension % 4, n, out);
}
static void pktrt__sampler_blue_noise(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample,
                                      uint32_t dimension, uint32_t n, float *out) {
  const uint64_t key = pktrt__sampler_key(s->seed, dimension / 4, x >> 8, y >> 8);
  const uint32_t run = pktrt__sampler_shuffled_morton(x, y, key);
  uint32_t digits[4];
  pktrt__sampler_sequence(pktrt__sampler_run_index(run, sample, s->samples, pktrt__hash(key + 4 + run)), digits);
  pktrt__sampler_scramble(digits, key, dimension % 4, n, out);
}

/* Gives coordinates of one group. Samples beyond the last begin again; what is no sampler is the first. */
static void pktrt__sampler_sample(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                                  uint32_t n, float *out) {
  const bool known = (int)s->sampler >= 0 && s->sampler < PKTRT_SAMPLER_COUNT;
  pktrt_sampling in_range = *s;
  in_range.samples = s->samples > 65536 ? 65536 : s->samples ? s->samples : 1;
  pktrt__sampler_rows[known ? s->sampler : PKTRT_SAMPLER_SOBOL].group(
      &in_range, x, y, sample < in_range.samples ? sample : sample % in_range.samples, dimension, n, out);
}

PKTRT_DEF void pktrt_sample(const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension,
                            uint32_t n, float *out) {
  while (n) {
    const uint32_t left = 4 - dimension % 4, take = n < left ? n : left;
    pktrt__sampler_sample(s, x, y, sample, dimension, take, out);
    dimension += take, out += take, n -= take;
  }
}

/* >>elementary: functions that decide pixels. libm's results differ between libraries; these are sums, products,
   quotients and square roots in a fixed order. Errors were found by comparing with libm over the ranges; they are
   relative, those of sine and cosine absolute. */

#define PKTRT__LOG2_HIGH 0.693147180369123816490 /* log 2, to so few bits that multiples up to 2^11 are exact */
#define PKTRT__LOG2_LOW 1.90821492927058770002e-10

/* Computes sine and cosine for |x| <= pi / 4, where their series end. Errors below 2^-51. */
static void pktrt__math_sincos(double x, double *sine, double *cosine) {
  const double q = x * x;
  double s = 0, c = pktrt__math_cosine_terms[0];
  for (int k = 0; k < 7; k++) s = (s + pktrt__math_sine_terms[k]) * q, c = c * q + pktrt__math_cosine_terms[k + 1];
  *sine = x + x * s, *cosine = 1 + c * q;
}

/* Computes sine and cosine of 2 pi turns, |turns| < 2^50. The nearest quarter turn is taken off exactly; what remains
   is within pi / 4. */
static void pktrt__math_sincos_turn(double turns, double *sine, double *cosine) {
  const double quarters = turns * 4, whole = (double)(int64_t)(quarters < 0 ? quarters - 0.5 : quarters + 0.5);
  double s, c;
  pktrt__math_sincos((quarters - whole) * (PKTRT__PI / 2), &s, &c);
  const int64_t turn = (int64_t)whole & 3;
  *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? -s : -c;
  *cosine = turn == 0 ? c : turn == 1 ? -s : turn == 2 ? -c : s;
}

/* Returns the angle in [0,pi] of the point (x, y), y >= 0, to the x axis: eight times that of an eighth, whose tangent
   is below 1/5. Error below 2^-50. */
static double pktrt__math_angle(double y, double x) {
  const double r = sqrt(x * x + y * y);
  if (!(r > 0)) return 0;
  double t = y / (r + fabs(x)), sum = 0;
  for (int i = 0; i < 2; i++) t /= 1 + sqrt(1 + t * t);
  const double q = t * t;
  for (int k = 23; k > 1; k -= 2) sum = q * (1.0 / k - sum);
  const double angle = 8 * (t - t * sum);
  return x < 0 ? PKTRT__PI - angle : angle;
}

/* Returns 2^k, -1022 <= k <= 1023. */
PKTRT__INLINE double pktrt__math_power_of_two(int32_t k) {
  const uint64_t bits = (uint64_t)(uint32_t)(k + 1023) << 52;
  double x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* Returns log(2^e (1 + f)), 1 + f within [sqrt(1/2), sqrt(2)]: twice the artanh of s = f / (2 + f), |s| < 0.172. */
static double pktrt__math_log_sum(int32_t e, double f) {
  const double s = f / (2 + f), q = s * s;
  double sum = q * (1.0 / 19);
  sum = (sum + 1.0 / 17) * q, sum = (sum + 1.0 / 15) * q, sum = (sum + 1.0 / 13) * q, sum = (sum + 1.0 / 11) * q;
  sum = (sum + 1.0 / 9) * q, sum = (sum + 1.0 / 7) * q, sum = (sum + 1.0 / 5) * q, sum = (sum + 1.0 / 3) * q;
  return (double)e * PKTRT__LOG2_HIGH + (2 * s + (2 * s * sum + (double)e * PKTRT__LOG2_LOW));
}

/* Returns the natural logarithm of a normal x > 0; -infinity for smaller ones. Error below 2^-51. */
static double pktrt__math_log(double x) {
  uint64_t bits;
  memcpy(&bits, &x, sizeof bits);
  if (!(x >= DBL_MIN)) return -INFINITY;
  /* the exponent that brings the fraction to [sqrt(1/2), sqrt(2)): 0x3FE6A09E... is sqrt(1/2) */
  const int32_t e = (int32_t)((bits - UINT64_C(0x3FE6A09E667F3BCD)) >> 52 & 0xFFF);
  const int32_t exponent = e >= 0x800 ? e - 0x1000 : e;
  bits -= (uint64_t)(int64_t)exponent << 52;
  memcpy(&x, &bits, sizeof x);
  return pktrt__math_log_sum(exponent, x - 1);
}

/* Returns log(1 - u), 0 <= u < 1, without loss for small u. */
static double pktrt__math_log1m(double u) { return u < 0.29 ? pktrt__math_log_sum(0, -u) : pktrt__math_log(1 - u); }

/* Returns exp(x) - 1 for |x| <= log(2) / 2. */
static double pktrt__math_expm1_sum(double x) {
  double sum = x * (1.0 / 6227020800);
  sum = (sum + 1.0 / 479001600) * x, sum = (sum + 1.0 / 39916800) * x, sum = (sum + 1.0 / 3628800) * x;
  sum = (sum + 1.0 / 362880) * x, sum = (sum + 1.0 / 40320) * x, sum = (sum + 1.0 / 5040) * x;
  sum = (sum + 1.0 / 720) * x, sum = (sum + 1.0 / 120) * x, sum = (sum + 1.0 / 24) * x, sum = (sum + 1.0 / 6) * x;
  return x + x * ((sum + 0.5) * x);
}

/* Returns e^x; error below 2^-51, and one step of a subnormal result. */
static double pktrt__math_exp(double x) {
  if (!(x > -746)) return x != x ? x : 0;
  if (x > 710) return INFINITY;
  const int32_t k = (int32_t)(x * 1.44269504088896340736 + (x < 0 ? -0.5 : 0.5)), half = k / 2;
  const double rest = (x - (double)k * PKTRT__LOG2_HIGH) - (double)k * PKTRT__LOG2_LOW;
  return (1 + pktrt__math_expm1_sum(rest)) * pktrt__math_power_of_two(half) * pktrt__math_power_of_two(k - half);
}

/* Returns exp(x) - 1 for x <= 0, without loss for small x. */
static double pktrt__math_expm1(double x) { return x > -0.34 ? pktrt__math_expm1_sum(x) : pktrt__math_exp(x) - 1; }

/* Returns x^y for x in [0,1], y >= 0; error below (1 + |y log x|) 2^-51. 0^0 is 1. */
static double pktrt__math_pow(double x, double y) { return y == 0 ? 1 : pktrt__math_exp(y * pktrt__math_log(x)); }
/* The same for whole numbers up to 4,096 by squaring, in a fifth of the time. */
static double pktrt__math_power(double x, double y) {
  double power = 1;
  if (!(y <= 4096 && y == (double)(uint32_t)y)) return pktrt__math_pow(x, y);
  for (uint32_t n = (uint32_t)y; n; n /= 2, x *= x)
    if (n % 2) power *= x;
  return power;
}

/* >>mappings ------------------------------------------------------------------------------------------------------- */

/* Computes two unit vectors perpendicular to the unit vector n and to each other (Duff et al. 2017): the x and y axes,
   turned as z is turned to n, or to -n if n points down. */
static void pktrt__map_basis(const double n[3], double t[3], double b[3]) {
  const double sign = n[2] < 0 ? -1 : 1, a = -1 / (sign + n[2]), c = n[0] * n[1] * a;
  t[0] = 1 + sign * n[0] * n[0] * a, t[1] = sign * c, t[2] = -sign * n[0];
  b[0] = c, b[1] = sign + n[1] * n[1] * a, b[2] = -n[1];
}

/* Turns the vector (x, y, z) as z is turned to an axis. */
static void pktrt__map_along(const double axis[3], double x, double y, double z, double out[3]) {
  double t[3], b[3];
  pktrt__map_basis(axis, t, b);
  for (int a = 0; a < 3; a++) out[a] = z * axis[a] + (x * t[a] + y * b[a]);
}

/* Computes the direction at height z along an axis and w = sqrt(1 - z^2) away from it, for turns in [0,1). Folds the
   turn to half of one about 1/4 and 3/4, where cosines are exactly 0. WHY: the series give half of that angle, which is
   doubled, and nothing has to be chosen by the quarter. */
static void pktrt__map_around(const double axis[3], double z, double w, double turns, double out[3]) {
  const double quarters = 4 * turns - 2;
  double s, c;
  pktrt__math_sincos((fabs(quarters) - 1) * (PKTRT__PI / 4), &s, &c);
  const double aside = w * (1 - (s + s) * s);
  pktrt__map_along(axis, w * ((s + s) * c), quarters < 0 ? aside : 0 - aside, z, out);
}

/* Clamps u to [0,1). */
PKTRT__INLINE double pktrt__map_clamp_unit(float u) { return u > 0 ? (double)pktrt__minf(u, 0.99999994f) : 0; }

/* Maps the square to the disk: squares around the centre become circles, evenly by angle (Shirley and Chiu 1997). */
static void pktrt__map_to_disk(const float u[2], double out[2]) {
  const double a = 2 * pktrt__map_clamp_unit(u[0]) - 1, b = 2 * pktrt__map_clamp_unit(u[1]) - 1;
  const bool wide = fabs(a) > fabs(b);
  const double along = wide ? a : b, size = pktrt__max(fabs(along), PKTRT__DISK_LEAST);
  double s, c;
  pktrt__math_sincos((wide ? b : a) / size * (PKTRT__PI / 4), &s, &c);
  out[wide ? 0 : 1] = along * c, out[wide ? 1 : 0] = size * s;
}

/* Maps the square to a cosine lobe: u[0] is the part nearer to the axis, u[1] the turn around it. Neighbours in the
   square are neighbours on the sphere, the origin is the axis, and the widest directions are a limit for u[0] = 1. (The
   disk's map, bent into a lobe, would have the origin at the widest. Measured, variance of edges is the same.) */
static void pktrt__map_cosine_lobe(const float u[2], const double normal[3], double out[3]) {
  const double x = pktrt__map_clamp_unit(u[0]);
  pktrt__map_around(normal, sqrt(1 - x), sqrt(x), pktrt__map_clamp_unit(u[1]), out);
}

/* Maps the square to a Phong lobe: the integral of cos^n gives 1 - u = cos^(n+1). For narrow lobes the sine comes from
   cos - 1, not from a cosine that is nearly 1. */
static void pktrt__map_phong_lobe(const float u[2], const double axis[3], double exponent, double out[3]) {
  const double x =
      pktrt__math_expm1(pktrt__math_log1m(pktrt__map_clamp_unit(u[0])) / ((exponent > 0 ? exponent : 0) + 1));
  pktrt__map_around(axis, 1 + x, sqrt(-x * (2 + x)), pktrt__map_clamp_unit(u[1]), out);
}

PKTRT__COLD void pktrt__map_phong_lobe_naive(const float u[2], const double axis[3], double exponent, double out[3]) {
  const double z = pktrt__math_pow(pktrt__map_clamp_unit(u[0]), 1 / ((exponent > 0 ? exponent : 0) + 1));
  pktrt__map_around(axis, z, sqrt(1 - z * z), pktrt__map_clamp_unit(u[1]), out);
}

PKTRT_DEF void pktrt_map_disk(const float u[2], float out[2]) {
  double p[2];
  pktrt__map_to_disk(u, p);
  out[0] = (float)p[0], out[1] = (float)p[1];
}

PKTRT_DEF void pktrt_map_sphere(const float u[2], float out[3]) {
  static const double up[3] = {0, 0, 1};
  const double x = pktrt__map_clamp_unit(u[0]);
  double d[3];
  pktrt__map_around(up, 1 - 2 * x, 2 * sqrt(x * (1 - x)), pktrt__map_clamp_unit(u[1]), d);
  for (int a = 0; a < 3; a++) out[a] = (float)d[a];
}

static void pktrt__map_unit_axis(const float axis[3], double out[3]) {
  for (int a = 0; a < 3; a++) out[a] = (double)axis[a];
  (void)pktrt__normalise(out);
}

PKTRT_DEF void pktrt_map_cosine(const float u[2], const float normal[3], float out[3]) {
  double n[3], d[3];
  pktrt__map_unit_axis(normal, n);
  pktrt__map_cosine_lobe(u, n, d);
  for (int a = 0; a < 3; a++) out[a] = (float)d[a];
}

PKTRT_DEF void pktrt_map_phong(const float u[2], const float axis[3], float exponent, float out[3]) {
  double n[3], d[3];
  pktrt__map_unit_axis(axis, n);
  pktrt__map_phong_lobe(u, n, (double)exponent, d);
  for (int a = 0; a < 3; a++) out[a] = (float)d[a];
}

PKTRT_DEF void pktrt_map_phong_naive(const float u[2], const float axis[3], float exponent, float out[3]) {
  double n[3], d[3];
  pktrt__map_unit_axis(axis, n);
  pktrt__map_phong_lobe_naive(u, n, (double)exponent, d);
  for (int a = 0; a < 3; a++) out[a] = (float)d[a];
}

/* >>fresnel -------------------------------------------------------------------------------------------------------- */

/* Evaluates the exact Fresnel equations for unpolarised light (Born and Wolf, Principles of Optics). */
PKTRT_DEF float pktrt_fresnel_dielectric(float cosine, float eta) {
  const double c = pktrt__min(pktrt__max((double)cosine, 0), 1), e = (double)eta;
  const double k =
      e < 0.5 ? e * e - (1 - c) * (1 + c) : c * c + (e - 1) * (e + 1); /* see pktrt__material_cosine_behind */
  if (!(k > 0) || e > FLT_MAX) return 1;                               /* infinite: the limit */
  const double b = sqrt(k) / e, s = (c - e * b) / (c + e * b), p = (e * c - b) / (e * c + b);
  return (float)(0.5 * (s * s + p * p));
}

/* Evaluates the Fresnel equations of metals. With s2 the squared sine,
   a^2 + b^2 = sqrt((eta^2 - k^2 - s2)^2 + 4 eta^2 k^2) and a^2 = (a^2 + b^2 + eta^2 - k^2 - s2) / 2. */
PKTRT_DEF float pktrt_fresnel_conductor(float cosine, float eta, float k) {
  const double c = pktrt__min(pktrt__max((double)cosine, 0), 1), c2 = c * c, s2 = 1 - c2;
  if (!(c > 0)) return 1;
  const double e2 = (double)eta * (double)eta, k2 = (double)k * (double)k, m = e2 - k2 - s2;
  const double ab = sqrt(m * m + 4 * e2 * k2), a = sqrt(pktrt__max(0, 0.5 * (ab + m)));
  const double s = (ab + c2 - 2 * a * c) / (ab + c2 + 2 * a * c);
  const double sum = c2 * ab + s2 * s2, p = sum > 0 ? (sum - 2 * a * c * s2) / (sum + 2 * a * c * s2) : 1;
  return (float)(0.5 * s * (1 + p));
}

/* >>lens ----------------------------------------------------------------------------------------------------------- */

/* Computes the camera at a time, 0 if it does not move. False if it has no direction, or up is parallel to that. */
static bool pktrt__camera_plane_at(const pktrt_camera *c, uint32_t width, uint32_t height, double time,
                                   pktrt__camera_plane *p) {
  double forward[3], up[3], s, k;
  const bool turns = c->moving && (c->up_end[0] != 0 || c->up_end[1] != 0 || c->up_end[2] != 0);
  for (int a = 0; a < 3; a++) {
    double eye = (double)c->eye[a], target = (double)c->target[a];
    if (c->moving) {
      eye = (1 - time) * eye + time * (double)c->eye_end[a];
      target = (1 - time) * target + time * (double)c->target_end[a];
    }
    p->eye[a] = eye;
    forward[a] = target - eye;
    up[a] = turns ? (1 - time) * (double)c->up[a] + time * (double)c->up_end[a] : (double)c->up[a];
  }
  p->focus = c->focus > 0 ? (double)c->focus : sqrt(pktrt__dot(forward, forward));
  if (up[0] == 0 && up[1] == 0 && up[2] == 0) up[1] = 1;
  if (!pktrt__normalise(forward) || !pktrt__normalise(up)) return false;
  pktrt__cross(forward, up, p->right);
  if (pktrt__dot(p->right, p->right) < 1e-12 || !pktrt__normalise(p->right)) return false;
  pktrt__cross(p->right, forward, p->up);
  const double fov = c->fov_y == 0 ? 45.0 : (double)c->fov_y;
  pktrt__math_sincos_turn(fov / 720, &s, &k);
  const double half_y = s / k, half_x = half_y * (double)width / (double)height;
  for (int a = 0; a < 3; a++) {
    p->corner[a] = forward[a] - half_x * p->right[a] + half_y * p->up[a];
    p->dx[a] = p->right[a] * (2 * half_x / (double)width);
    p->dy[a] = p->up[a] * (-2 * half_y / (double)height);
  }
  return true;
}

PKTRT__COLD bool pktrt__camera_check(const pktrt_camera *c, uint32_t width, uint32_t height, pktrt__camera_plane *p,
                                     pktrt__refusal *why) {
  const float *vectors[6] = {c->eye, c->target, c->up, c->eye_end, c->target_end, c->up_end};
  static const char *const names[6] = {"eye", "target", "up", "eye_end", "target_end", "up_end"};
  for (int i = 0; i < (c->moving ? 6 : 3); i++)
    for (int a = 0; a < 3; a++)
      if (!(fabsf(vectors[i][a]) <= PKTRT_MAX_COORD))
        return pktrt__render_refuse(why, "camera: %c of %s is %g", 'x' + a, names[i], (double)vectors[i][a]);
  if (!(c->fov_y >= 0 && c->fov_y < 180))
    return pktrt__render_refuse(why, "camera: fov_y is %g, outside (0, 180) degrees", (double)c->fov_y);
  if (!(c->time >= 0 && c->time <= 1))
    return pktrt__render_refuse(why, "camera: time is %g, outside [0, 1]", (double)c->time);
  if (!(c->shutter >= 0 && (double)c->time + (double)c->shutter <= 1 + 1e-6)) /* as sums of decimals come out */
    return pktrt__render_refuse(why, "camera: shutter is %g, outside [0, 1 - time]", (double)c->shutter);
  if (!(c->aperture >= 0 && c->aperture <= PKTRT_MAX_COORD))
    return pktrt__render_refuse(why, "camera: aperture is %g", (double)c->aperture);
  if (!(c->focus >= 0 && c->focus <= PKTRT_MAX_COORD))
    return pktrt__render_refuse(why, "camera: focus is %g", (double)c->focus);
  for (int end = c->moving ? 1 : 0; end >= 0; end--) {
    if (pktrt__camera_plane_at(c, width, height, end, p)) continue;
    const float *eye = end ? c->eye_end : c->eye, *target = end ? c->target_end : c->target;
    if (eye[0] == target[0] && eye[1] == target[1] && eye[2] == target[2])
      return pktrt__render_refuse(why, "camera: eye and target are the same point (%g, %g, %g)", (double)eye[0],
                                  (double)eye[1], (double)eye[2]);
    const bool turns = end && (c->up_end[0] != 0 || c->up_end[1] != 0 || c->up_end[2] != 0);
    const float *up = turns ? c->up_end : c->up;
    const bool plain = up[0] == 0 && up[1] == 0 && up[2] == 0;
    return pktrt__render_refuse(why, "camera: up (%g, %g, %g) is parallel to the view at time %d", (double)up[0],
                                plain ? 1 : (double)up[1], (double)up[2], end);
  }
  return true;
}

/* One sample of a camera: a place of the picture, in pixels; a point of the lens, on the unit disk; a time. */
typedef struct pktrt__camera_sample {
  double x, y, time;
  float disk[2];
} pktrt__camera_sample;

/* Makes the ray of a sample; its direction is zero where a moving camera stands in its target. */
static void pktrt__camera_ray_at(const pktrt_camera *c, uint32_t width, uint32_t height,
                                 const pktrt__camera_plane *at_rest, const pktrt__camera_sample *s, float o[3],
                                 float direction[3]) {
  const double half = 0.5 * (double)c->aperture, lens[2] = {half * (double)s->disk[0], half * (double)s->disk[1]};
  pktrt__camera_plane moved;
  const pktrt__camera_plane *p = at_rest;
  bool sees = true;
  if (PKTRT__MOTION && c->moving) {
    memset(&moved, 0, sizeof moved);
    sees = pktrt__camera_plane_at(c, width, height, s->time, &moved), p = &moved;
  }
  for (int a = 0; a < 3; a++) {
    const double d = p->corner[a] + s->x * p->dx[a] + s->y * p->dy[a];
    const double off = lens[0] * p->right[a] + lens[1] * p->up[a];
    o[a] = pktrt__to_float(p->eye[a] + off);
    direction[a] = sees ? pktrt__to_float(d - off / p->focus) : 0;
  }
}

PKTRT_DEF bool pktrt_camera_ray(const pktrt_camera *c, uint32_t width, uint32_t height, double x, double y,
                                const float lens[2], float time, pktrt_ray *ray) {
  const float none[3] = {0, 0, 0};
  float o[3], d[3];
  pktrt__camera_plane plane;
  pktrt__camera_sample sample = {x, y, (double)time, {0, 0}};
  pktrt__refusal why;
  *ray = pktrt_make_ray(none, none), ray->tmax = 0;
  if (!c || !width || !height || !pktrt__camera_check(c, width, height, &plane, &why)) return false;
  if ((!PKTRT__MOTION && c->moving) || (!PKTRT__LENS && c->aperture > 0)) return false;
  if (lens && c->aperture > 0) pktrt_map_disk(lens, sample.disk);
  pktrt__camera_ray_at(c, width, height, &plane, &sample, o, d);
  *ray = pktrt_make_ray(o, d), ray->time = time;
  return true;
}

/* >>request: a render, checked and complete ------------------------------------------------------------------------ */

/* A triangle of a mesh that is a light. */
typedef struct pktrt__light_triangle { /* where it is, if its mesh has one key */
  double corner[3], edge[2][3];
  double normal[3], length; /* cross product of the edges, and its length */
  double area;              /* at rest, or the largest over its mesh's keys and half-way between them */
  uint32_t triangle;        /* of its mesh */
} pktrt__light_triangle;
typedef struct pktrt__light_cluster { /* triangles that lie together: half of those of the cluster above */
  double middle[3], r2;               /* of a sphere around them at rest; r2: its radius, squared */
  double area;
  double facing[3], bent; /* sum of their areas as vectors, outwards; 0: they face one way, 1: half a ball or more */
} pktrt__light_cluster;
typedef struct pktrt__light_cdf {
  double sum;     /* of the areas up to this triangle's, which is included */
  uint32_t start; /* entry i: the first triangle that part i of as many equal parts of the sum can fall to */
} pktrt__light_cdf;

/* The parts of the tree over all lights that surfaces in a cell of space choose from, if they face one of six ways: those
   that are far for their size, and single lights. */
enum { PKTRT__LIGHT_CUT = 64, PKTRT__LIGHT_CUTS = 64 };
typedef struct pktrt__light_cut {
  int32_t cell[4]; /* and the way; -1: it holds nothing */
  uint32_t count;
  double sum[PKTRT__LIGHT_CUT]; /* of the weights up to each, which is included */
  uint32_t at[PKTRT__LIGHT_CUT], first[PKTRT__LIGHT_CUT], n[PKTRT__LIGHT_CUT];
} pktrt__light_cut;

/* A table of what an environment has beyond twice its mean, in rows from the zenith (+y) down, of equal angles. */
typedef struct pktrt__environment {
  void (*radiance)(void *user, uint32_t n, const float *const direction[3],
                   float *const radiance[3]); /* in the table */
  void *user;
  uint32_t rows; /* and twice as many columns */
  double *edge;  /* cosines between them, rows + 1 */
  double *sum;   /* of rows up to each, which is included, with their solid angles */
  float *along;  /* of each row, sums of its cells up to each, which is included */
  double share;  /* of samples that are drawn from the table, the others by cosine; 0: all are */
} pktrt__environment;

/* What is known of a light before the first ray. */
struct pktrt__light_data {
  double middle[3], radius; /* mesh: of a sphere around it */
  double area;              /* quad, mesh */
  double near2;             /* quad: squared distance of its middle, within which its solid angle is sampled */
  double facing[3];         /* quad: unit normal; directional: unit, towards it; mesh: sum of its areas as vectors */
  double strength;          /* radiance or intensity: of its largest component, */
  float color[3];           /* and all three relative to that; products stay in range so */
  pktrt__light_target target;
  pktrt__light_triangle *triangles; /* mesh: neighbours lie near each other */
  pktrt__light_cdf *cdf;
  pktrt__light_cluster *clusters; /* 2 facet_count - 1: see pktrt__light_make_clusters */
  uint32_t *places;               /* of the triangles of its mesh among `triangles`; NULL unless lobes need to know */
  uint32_t triangle_count;
  double back; /* mesh: how much counts, against one that faces a point, a triangle that looks away */
  bool both;   /* rays of lobes find it, and share its light with samples of it, see >>direct */
};

/* What pixels have had so far, where there are several passes. */
typedef struct pktrt__pixel_sums {
  double mean[3], squares; /* of the means of passes: their sum, and that of their squares over all channels */
  float gain, splits;      /* see pktrt__split_end */
} pktrt__pixel_sums;
typedef struct pktrt__aov_sums { /* of all samples */
  double depth, normal[3], albedo[3], met;
} pktrt__aov_sums;
enum {
  PKTRT__PASS_CELL = 4, /* pixels along the edge of the cells that get passes together */
  PKTRT__PILOT = 2      /* passes that all cells get before errors are known */
};
typedef struct pktrt__pass_cell {
  double variance;             /* of one pass, V n: sum over its pixels whose error is known */
  double want;                 /* passes it should have had, see pktrt__pass_share_out */
  uint32_t pixels, done, more; /* passes it has had, and gets in this round */
  bool split;                  /* both rays are followed at its first glass */
} pktrt__pass_cell;
typedef struct pktrt__pass_block { /* of PKTRT_ERROR_BLOCK^2 pixels */
  double error[2];                 /* sums over its pixels: V, and V as in the relative MSE */
  double squares, doubt;           /* sums of V^2, and of what it says of the square of V's distance from the truth */
  double mean[3];                  /* of its pixels, their sum */
  double weight;                   /* of V in the relative MSE */
  uint32_t pixels, unknown;        /* unknown: pixels left out */
} pktrt__pass_block;
typedef struct pktrt__pass_sums {
  pktrt__pixel_sums *sums; /* of the pixels of an area */
  pktrt__aov_sums *aovs;   /* NULL: not wanted */
  pktrt__pass_cell *cells;
  pktrt__pass_block *blocks;
  uint32_t x, y, w, h;              /* the area */
  uint32_t columns, rows;           /* of blocks */
  uint32_t cell_columns, cell_rows; /* of cells */
  double samples;                   /* of a pass */
} pktrt__pass_sums;

struct pktrt__render_state {
  const pktrt_scene *scene;
  const pktrt_render_desc *desc;
  pktrt__camera_plane plane;       /* of a camera that does not move */
  pktrt__light_data *lights;       /* one for each light */
  pktrt__environment *environment; /* to draw from; NULL: by cosine alone */
  pktrt__light_cluster *tree;      /* over lights that are not infinitely far, as `ordered`; NULL: all are asked */
  uint32_t *ordered;               /* these lights, then the others */
  uint32_t finite;                 /* how many they are */
  bool shown;                      /* some lights are visible */
  bool splits;                     /* passes find out where it pays to follow both rays at the first glass */
  bool two_ways;                   /* of some lights, both samples and lobes may find the light */
  uint32_t sky_light;              /* the environment light that lobes share, or NONE */
  uint32_t *light_of_mesh;  /* for each committed mesh: the light whose light is shared, or NONE; NULL: there is none */
  pktrt_sampling sampling;  /* of the first pass */
  pktrt__pass_sums *passes; /* NULL: there is one */
  uint32_t packet_size, tile_size, samples, max_depth;
  uint32_t most_passes;      /* uniformly; of a block, if adaptive: what a 32-bit count of samples can hold */
  bool random;               /* the place in the pixel */
  uint32_t event_dimensions; /* sample dimensions of one scattering event: 4, and 2 for each light */
  float threshold;           /* of importance */
  size_t row_stride;
  bool sums_only;                  /* pixels are not written */
  uint32_t features;               /* of pktrt_feature: those that run; ask by pktrt__render_uses */
  bool follow, distribute, choose; /* secondary rays; random lens, lights and lobes; one ray at a dielectric */
  bool draws;                      /* scattering events or lights take samples */
  bool watched;                    /* who looks at packets wants to know what their rays add to */
  pktrt__glass_boxes glass;
  pktrt__glass_mesh *glass_meshes; /* for each committed mesh; NULL: no glass is seen */
  bool starts_in_glass;            /* perhaps: the camera stands in the box of a mesh of glass */
  bool passes_glass;               /* shadow rays do */
  bool cutouts;                    /* there are materials with transparent points */
};

PKTRT__COLD bool pktrt__render_check_sizes(const pktrt_render_desc *d, pktrt__refusal *why) {
  const uint32_t p = d->packet_size;
  if (!d->width || !d->height || d->width > 65536 || d->height > 65536)
    return pktrt__render_refuse(why, "a picture of %u x %u pixels is outside 1 to 65536", (unsigned)d->width,
                                (unsigned)d->height);
  if (!d->pixels) return pktrt__render_refuse(why, "pixels is NULL");
  if (d->row_stride && d->row_stride < (size_t)d->width * 3)
    return pktrt__render_refuse(why, "row_stride %llu is below width * 3", (unsigned long long)d->row_stride);
  if (p && p != 2 && p != 4 && p != 8 && p != 16)
    return pktrt__render_refuse(why, "packet_size %u is not 2, 4, 8 or 16", (unsigned)p);
  if (d->tile_size > 1024) return pktrt__render_refuse(why, "tile_size %u is above 1024", (unsigned)d->tile_size);
  if (d->samples > 65536) return pktrt__render_refuse(why, "%u samples are above 65536", (unsigned)d->samples);
  if (d->passes > 65536) return pktrt__render_refuse(why, "%u passes are above 65536", (unsigned)d->passes);
  if ((uint64_t)d->passes * d->samples > UINT32_MAX)
    return pktrt__render_refuse(why, "%u passes of %u samples are 2^32 or more", (unsigned)d->passes,
                                (unsigned)d->samples);
  if (d->max_depth > PKTRT_MAX_DEPTH)
    return pktrt__render_refuse(why, "max_depth %u is above %u", (unsigned)d->max_depth, (unsigned)PKTRT_MAX_DEPTH);
  if (!(d->attenuation <= 1)) return pktrt__render_refuse(why, "attenuation is %g, above 1", (double)d->attenuation);
  return true;
}

PKTRT__COLD bool pktrt__render_check_enums(const pktrt_render_desc *d, pktrt__refusal *why) {
  const struct {
    int value, last;
    const char *name;
  } words[] = {{(int)d->mode, PKTRT_MODE_DRT, "pktrt_mode"},
               {(int)d->path, PKTRT_PATH_SINGLE, "pktrt_path"},
               {(int)d->normals, PKTRT_NORMALS_GEOMETRIC, "pktrt_normals"},
               {(int)d->shadows, PKTRT_SHADOWS_TOGETHER, "pktrt_shadow_packets"},
               {(int)d->sampler, PKTRT_SAMPLER_CUSTOM, "pktrt_sampler"},
               {(int)d->assembly, PKTRT_ASSEMBLY_NONE, "pktrt_assembly"},
               {(int)d->branching, PKTRT_BRANCHING_FIRST, "pktrt_branching"},
               {(int)d->lights, PKTRT_LIGHTS_ONE, "pktrt_light_choice"},
               {(int)d->glass_shadows, PKTRT_GLASS_SHADOWS_BLOCK, "pktrt_glass_shadows"},
               {(int)d->phong_mapping, PKTRT_PHONG_NAIVE, "pktrt_phong_mapping"},
               {(int)d->measure, PKTRT_ERROR_RELATIVE, "pktrt_error_measure"},
               {(int)d->cost_of, PKTRT_COST_VECTORS, "pktrt_cost"}};
  for (size_t i = 0; i < sizeof words / sizeof *words; i++)
    if (words[i].value < 0 || words[i].value > words[i].last)
      return pktrt__render_refuse(why, "%d is no %s", words[i].value, words[i].name);
  if (d->sampler == PKTRT_SAMPLER_CUSTOM && !d->custom_sampler)
    return pktrt__render_refuse(why, "sampler is PKTRT_SAMPLER_CUSTOM, but custom_sampler is NULL");
  for (int a = 0; a < 3; a++)
    if (!pktrt__is_finite(d->background[a]) || !pktrt__is_finite(d->ambient[a]))
      return pktrt__render_refuse(why, "component %d of background and ambient is %g and %g", a,
                                  (double)d->background[a], (double)d->ambient[a]);
  return true;
}

PKTRT__COLD bool pktrt__render_check_rules(const pktrt_render_desc *d, pktrt__refusal *why) {
  if (!(d->target_error >= 0 && d->target_error < INFINITY))
    return pktrt__render_refuse(why, "target_error is %g", (double)d->target_error);
  if (!(d->time_budget >= 0)) return pktrt__render_refuse(why, "time_budget is %g", d->time_budget);
  if (d->passes == 1 && d->target_error > 0)
    return pktrt__render_refuse(why, "target_error with one pass: errors are estimated from two passes on");
  if (d->adaptive && (d->passes == 1 || (!d->passes && !(d->target_error > 0) && !(d->time_budget > 0) && !d->pass)))
    return pktrt__render_refuse(why, "adaptive passes need a rule when to stop, and two passes before it");
  return true;
}

/* Tells whether meshes were added, but never committed: a picture would be empty. */
static bool pktrt__render_is_uncommitted(const pktrt_scene *s) { return s->mesh_count && !s->committed_meshes; }

PKTRT__COLD bool pktrt__render_check_scene(const pktrt_scene *s, pktrt__refusal *why) {
  for (uint32_t i = 0; i < s->committed_meshes; i++)
    if (s->meshes[i].material > s->material_count)
      return pktrt__render_refuse(why, "mesh %u names material %u, of %u that were added", (unsigned)i,
                                  (unsigned)s->meshes[i].material, (unsigned)s->material_count);
  for (uint32_t i = 0; i < s->light_count; i++)
    if (pktrt__light_has(&s->lights[i], PKTRT__LIGHT_EMISSIVE) && s->lights[i].mesh >= s->committed_meshes)
      return pktrt__render_refuse(why, "light %u names mesh %u, of %u that were committed", (unsigned)i,
                                  (unsigned)s->lights[i].mesh, (unsigned)s->committed_meshes);
  for (uint32_t i = 0; i < s->light_count; i++) {
    const pktrt__mesh *m = &s->meshes[s->lights[i].mesh];
    if (!pktrt__light_has(&s->lights[i], PKTRT__LIGHT_EMISSIVE) || (m->committed && !m->instance)) continue;
    return pktrt__render_refuse(why, "light %u names mesh %u, %s", (unsigned)i, (unsigned)s->lights[i].mesh,
                                m->instance ? "of an instance: lights are meshes that were added directly"
                                            : "which was removed");
  }
  return true;
}

/* Finds the features that the surfaces and lights of a scene have. */
static uint32_t pktrt__feature_of_scene(const pktrt_scene *s) {
  uint32_t found = 0;
  for (uint32_t i = 0; i < s->committed_meshes; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    found |= pktrt__feature_of_mesh(s, i);
    if (!m->triangle_count || m->material > s->material_count) continue; /* refused by renders */
    const pktrt_material *mat = pktrt__material_of(s, m->material);
    if (mat->texture || mat->shader) found |= PKTRT_FEATURE_TEXTURES;
    if (mat->cutout) found |= PKTRT_FEATURE_SURFACES;
    if (pktrt__material_has_lobe(mat)) found |= PKTRT_FEATURE_GLOSS;
    found |= pktrt__specular_rows[mat->specular].feature;
  }
  for (uint32_t i = 0; i < s->light_count; i++)
    if (pktrt__light_has(&s->lights[i], PKTRT__LIGHT_AREA)) found |= PKTRT_FEATURE_AREA_LIGHTS;
  return found;
}

static uint32_t pktrt__feature_of_render(const pktrt_scene *s, const pktrt_render_desc *d) {
  uint32_t found = pktrt__feature_of_scene(s) | PKTRT_FEATURE_RENDER;
  if (d->camera.moving) found |= PKTRT_FEATURE_MOTION;
  if (d->camera.aperture > 0) found |= PKTRT_FEATURE_LENS;
  if (d->camera.shutter > 0) found |= PKTRT_FEATURE_SHUTTER;
  if (d->path == PKTRT_PATH_PAPER) found |= PKTRT_FEATURE_PAPER;
  if (d->stats || d->trace || d->cost) found |= PKTRT_FEATURE_STATS;
  return found & PKTRT__BUILT;
}

/* Drops from the features that were found those that a picture of this kind does not show. */
static uint32_t pktrt__feature_used(const pktrt_render_desc *d, uint32_t found) {
  if (d->mode == PKTRT_MODE_RCS) found &= ~(uint32_t)((int)PKTRT__SPECULAR | (int)PKTRT_FEATURE_GLOSS);
  if (d->mode != PKTRT_MODE_DRT) found &= ~(uint32_t)(PKTRT_FEATURE_LENS | PKTRT_FEATURE_SHUTTER);
  if (d->normals != PKTRT_NORMALS_SMOOTH) found &= ~(uint32_t)PKTRT_FEATURE_NORMALS;
  /* nobody sees when, save hooks */
  if (!(found & (PKTRT_FEATURE_MOTION | PKTRT_FEATURE_TEXTURES))) found &= ~(uint32_t)PKTRT_FEATURE_SHUTTER;
  return found;
}

/* Tells whether a render needs any of these features; constantly not, if the build left them out. */
PKTRT__INLINE bool pktrt__render_uses(const pktrt__render_state *render, uint32_t features) {
  return (PKTRT__BUILT & features) && (render->features & features);
}

/* Returns a sentence on the first thing that a description asks for and the build left out; NULL: there is none. */
static const char *pktrt__render_left_out(const pktrt_render_desc *d) {
  if (!PKTRT__MOTION && d->camera.moving) return "camera: it moves, but this build has PKTRT_NO_MOTION";
  if (!PKTRT__LENS && d->camera.aperture > 0) return "camera: it has an aperture, but this build has PKTRT_NO_LENS";
  if (!PKTRT__SHUTTER && d->camera.shutter > 0) return "camera: it has a shutter, but this build has PKTRT_NO_SHUTTER";
  if (!PKTRT__PAPER && d->path == PKTRT_PATH_PAPER) return "path is the paper's, but this build has PKTRT_NO_PAPER";
  if (!PKTRT__STATS && (d->stats || d->trace || d->cost))
    return "stats, events or cost are asked for, but this build has PKTRT_NO_STATS";
  return NULL;
}

static bool pktrt__render_check(const pktrt_scene *s, const pktrt_render_desc *d, pktrt__render_state *render,
                                pktrt__refusal *why) {
  memset(render, 0, sizeof *render);
  if (!d) return pktrt__render_refuse(why, "the description is NULL");
  if (!pktrt__render_check_sizes(d, why) || !pktrt__render_check_enums(d, why) || !pktrt__render_check_rules(d, why) ||
      !pktrt__render_check_scene(s, why))
    return false;
  if (pktrt__render_left_out(d)) return pktrt__render_refuse(why, "%s", pktrt__render_left_out(d));
  render->scene = s, render->desc = d, render->sky_light = PKTRT_NONE;
  render->features = pktrt__feature_used(d, pktrt__feature_of_render(s, d));
  render->packet_size = d->packet_size ? d->packet_size : 8;
  render->tile_size = d->tile_size ? d->tile_size : 64;
  render->samples = d->samples ? d->samples : 1;
  render->max_depth = d->max_depth ? d->max_depth : PKTRT_MAX_DEPTH;
  render->threshold = d->attenuation == 0 ? 1.0f / 256 : d->attenuation;
  render->row_stride = d->row_stride ? d->row_stride : (size_t)d->width * 3;
  render->follow = pktrt__render_uses(render, PKTRT__SPECULAR), render->distribute = d->mode == PKTRT_MODE_DRT;
  render->choose =
      d->branching >= PKTRT_BRANCHING_CHOOSE || (render->distribute && d->branching == PKTRT_BRANCHING_BY_MODE);
  const bool random_lights = pktrt__render_uses(render, PKTRT_FEATURE_AREA_LIGHTS) || d->lights != PKTRT_LIGHTS_ALL;
  render->draws = (render->distribute && (random_lights || pktrt__render_uses(render, PKTRT_FEATURE_GLOSS))) ||
                  (render->choose && pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC));
  render->sampling.sampler = d->sampler, render->sampling.samples = render->samples, render->sampling.seed = d->seed;
  render->watched = d->packet || (PKTRT__STATS && (d->trace || d->cost));
  render->most_passes = d->passes;
  if (!d->passes) render->most_passes = d->target_error > 0 || d->time_budget > 0 || d->pass ? 65536 : 1;
  if (render->most_passes > UINT32_MAX / render->samples) render->most_passes = UINT32_MAX / render->samples;
  render->splits = render->distribute && d->branching == PKTRT_BRANCHING_BY_MODE && d->adaptive &&
                   pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC);
  render->random = render->distribute || render->samples > 1 || render->most_passes > 1;
  render->event_dimensions = 4 + (d->lights == PKTRT_LIGHTS_ONE ? 4 : (2 * s->light_count + 3) / 4 * 4);
  return pktrt__camera_check(&d->camera, d->width, d->height, &render->plane, why);
}

/* >>lights --------------------------------------------------------------------------------------------------------- */

static void pktrt__light_place_triangle(float p[3][3], pktrt__light_triangle *f) {
  (void)pktrt__tri_normal(p, f->normal);
  f->length = sqrt(pktrt__dot(f->normal, f->normal));
  for (int a = 0; a < 3; a++) {
    f->corner[a] = (double)p[0][a];
    f->edge[0][a] = (double)p[1][a] - f->corner[a], f->edge[1][a] = (double)p[2][a] - f->corner[a];
  }
}

/* Fills in a light's triangle at key 0, which RCS and WRT take for all keys, and its normal, as long as two areas;
   returns the largest area over its keys and half-way between them. Between two keys the normal is a quadratic in time:
   if it is zero at both, it is zero half-way only if it is zero throughout. */
PKTRT__COLD double pktrt__light_set_triangle(const pktrt__mesh *m, uint32_t triangle, pktrt__light_triangle *f,
                                             double n[3]) {
  float p[3][3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, next[3][3], half[3][3]; /* there is a key, but gcc does not know */
  double largest = 0;
  for (uint32_t key = m->key_count; key-- > 0;) {
    memcpy(next, p, sizeof next);
    pktrt__mesh_triangle(m, false, triangle, key, p);
    for (int i = 0; key + 1 < m->key_count && i < 9; i++)
      half[i / 3][i % 3] = 0.5f * p[i / 3][i % 3] + 0.5f * next[i / 3][i % 3];
    if (key + 1 < m->key_count) (void)pktrt__tri_normal(half, n), largest = pktrt__max(largest, pktrt__dot(n, n));
    (void)pktrt__tri_normal(p, n);
    largest = pktrt__max(largest, pktrt__dot(n, n));
  }
  largest = 0.5 * sqrt(largest);
  pktrt__light_place_triangle(p, f);
  return largest;
}

/* Finds the triangle that a number in [0, total) falls to, by the cdf. */
static uint32_t pktrt__light_find_triangle(const pktrt__light_data *light, double want) {
  const uint32_t n = light->triangle_count, part = (uint32_t)(want / light->cdf[n - 1].sum * (double)n);
  uint32_t i = light->cdf[part < n ? part : n - 1].start;
  while (i + 1 < n && light->cdf[i].sum <= want) i++;
  return i;
}

/* Returns a point's place on a Morton curve through a box, 10 bits for each axis, in the upper half. */
PKTRT__COLD uint64_t pktrt__light_morton_key(const double at[3], const double lo[3], double size) {
  uint64_t key = 0;
  for (uint32_t a = 0; a < 3; a++) {
    const double part = size > 0 ? (at[a] - lo[a]) / size : 0;
    const uint32_t cell = (uint32_t)(pktrt__min(pktrt__max(part, 0), 1) * 1023);
    for (uint32_t bit = 0; bit < 10; bit++) key |= (uint64_t)(cell >> bit & 1) << (32 + 3 * bit + a);
  }
  return key;
}
PKTRT__COLD uint64_t pktrt__light_triangle_key(const pktrt__mesh *m, uint32_t triangle, const double lo[3],
                                               double size) {
  float p[3][3];
  double middle[3];
  pktrt__mesh_triangle(m, false, triangle, 0, p);
  for (uint32_t a = 0; a < 3; a++) middle[a] = ((double)p[0][a] + (double)p[1][a] + (double)p[2][a]) / 3;
  return pktrt__light_morton_key(middle, lo, size) | triangle;
}

/* Makes clusters by halving: next to that of n triangles stands that of the first n / 2, the rest's 2 (n / 2) after. */
PKTRT__COLD void pktrt__light_make_clusters(pktrt__light_data *light) {
  struct {
    uint32_t at, first, n;
  } stack[34] = {{0, 0, light->triangle_count}};
  for (uint32_t top = light->triangle_count ? 1 : 0; top--;) {
    const uint32_t at = stack[top].at, first = stack[top].first, n = stack[top].n;
    pktrt__light_cluster *c = &light->clusters[at];
    memset(c, 0, sizeof *c);
    for (uint32_t i = first; i < first + n; i++) {
      const pktrt__light_triangle *f = &light->triangles[i];
      c->area += f->area;
      for (int a = 0; a < 3; a++) c->facing[a] += 0.5 * f->normal[a];
      for (int a = 0; a < 3; a++) c->middle[a] += (f->corner[a] + (f->edge[0][a] + f->edge[1][a]) / 3) / n;
    }
    for (uint64_t i = 0; i < 3 * (uint64_t)n; i++) {
      const pktrt__light_triangle *f = &light->triangles[first + i / 3];
      double d[3];
      for (int a = 0; a < 3; a++) d[a] = f->corner[a] + (i % 3 ? f->edge[i % 3 - 1][a] : 0) - c->middle[a];
      c->r2 = pktrt__max(c->r2, pktrt__dot(d, d));
    }
    const double length = sqrt(pktrt__dot(c->facing, c->facing));
    c->bent = c->area > 0 ? pktrt__min(1, 2 * pktrt__max(0, 1 - length / c->area)) : 0;
    if (n == 1) continue;
    stack[top].at = at + 1, stack[top].first = first, stack[top++].n = n / 2;
    stack[top].at = at + 2 * (n / 2), stack[top].first = first + n / 2, stack[top++].n = n - n / 2;
  }
}

/* Finds whether triangles that look away from a point outside are hidden from it, as in a globe: if the light is
   closed, that is, its areas cancel as vectors, and all of them look away from its middle, or all towards it; then
   facings are turned outwards. */
PKTRT__COLD void pktrt__light_find_back(pktrt__light_data *light) {
  const pktrt__light_cluster *all = light->clusters;
  const double open = all->area > 0 ? sqrt(pktrt__dot(all->facing, all->facing)) / all->area : 1;
  double outwards = 0;
  for (uint32_t i = 0; i < light->triangle_count; i++) {
    const pktrt__light_triangle *f = &light->triangles[i];
    double d[3];
    for (int a = 0; a < 3; a++) d[a] = f->corner[a] + (f->edge[0][a] + f->edge[1][a]) / 3 - all->middle[a];
    outwards += pktrt__dot(d, f->normal) < 0 ? -f->area : f->area;
  }
  light->back = all->area > 0 ? 1 - (1 - pktrt__min(1, open)) * fabs(outwards) / all->area : 1;
  for (uint32_t i = 0; outwards < 0 && i + 1 < 2 * light->triangle_count; i++)
    for (int a = 0; a < 3; a++) light->clusters[i].facing[a] = -light->clusters[i].facing[a];
}

/* Fills in the triangles of a mesh that is a light, its cdf and its clusters. They are sorted by key, then number: the
   sample's first coordinate runs through all of them, and where it is stratified, so is the light's surface if
   neighbours in the order are neighbours in space. */
PKTRT__COLD bool pktrt__light_make_triangles(const pktrt_scene_desc *desc, const pktrt__mesh *m,
                                             pktrt__light_data *light, const double lo[3], double size) {
  const uint32_t n = light->triangle_count = m->triangle_count;
  double sum = 0, ignored[3];
  uint64_t *key = PKTRT__CAST(uint64_t *, pktrt__mem_alloc(desc, n, sizeof *key));
  light->triangles = PKTRT__CAST(pktrt__light_triangle *, pktrt__mem_alloc(desc, n, sizeof *light->triangles));
  light->cdf = PKTRT__CAST(pktrt__light_cdf *, pktrt__mem_alloc(desc, n, sizeof *light->cdf));
  light->clusters =
      PKTRT__CAST(pktrt__light_cluster *, pktrt__mem_alloc(desc, 2 * (uint64_t)n, sizeof *light->clusters));
  const bool ok = key && light->triangles && light->cdf && light->clusters;
  for (uint32_t i = 0; ok && i < n; i++) key[i] = pktrt__light_triangle_key(m, i, lo, size);
  if (ok) pktrt__sort_keys(key, n);
  for (uint32_t i = 0; ok && i < n; i++) {
    pktrt__light_triangle *f = &light->triangles[i];
    f->triangle = (uint32_t)key[i];
    f->area = pktrt__light_set_triangle(m, f->triangle, f, ignored);
    light->cdf[i].sum = sum += f->area;
  }
  for (uint32_t i = 0, at = 0; ok && i < n; i++) {
    while (at + 1 < n && light->cdf[at].sum <= sum * i / n * (1 - 1e-9)) at++; /* rather one too early */
    light->cdf[i].start = at;
  }
  if (ok) pktrt__light_make_clusters(light);
  if (ok && n) pktrt__light_find_back(light);
  pktrt__mem_release(desc, key, n, sizeof *key);
  return ok;
}

/* Prepares a mesh as a light: by its triangles for DRT, as a point for the other modes. */
PKTRT__COLD bool pktrt__light_prepare_mesh(const pktrt__render_state *render, const pktrt_light *l,
                                           pktrt__light_data *light) {
  pktrt__mesh shown = render->scene->meshes[l->mesh];
  if (shown.hidden) shown.triangle_count = 0;
  const pktrt__mesh *m = &shown;
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, size = 0, normal[3];
  for (uint32_t i = 0; i < m->triangle_count; i++) {
    pktrt__light_triangle f;
    (void)pktrt__light_set_triangle(m, i, &f, normal);
    const double area = 0.5 * f.length;
    light->area += area;
    for (int a = 0; a < 3; a++) {
      light->facing[a] += 0.5 * normal[a];
      light->middle[a] += area * (f.corner[a] + (f.edge[0][a] + f.edge[1][a]) / 3);
    }
  }
  for (int a = 0; a < 3 && light->area > 0; a++) light->middle[a] /= light->area;
  for (uint64_t i = 0; i < (uint64_t)m->triangle_count * m->key_count; i++) {
    float p[3][3];
    pktrt__mesh_triangle(m, false, (uint32_t)(i % m->triangle_count), (uint32_t)(i / m->triangle_count), p);
    for (int c = 0; c < 3; c++) {
      double r2 = 0;
      for (int a = 0; a < 3; a++) {
        const double x = (double)p[c][a], d = x - light->middle[a];
        r2 += d * d;
        lo[a] = pktrt__min(lo[a], x), hi[a] = pktrt__max(hi[a], x);
      }
      if (r2 > light->radius * light->radius) light->radius = sqrt(r2);
    }
  }
  for (int a = 0; a < 3; a++) size = pktrt__max(size, hi[a] - lo[a]);
  return !render->distribute || pktrt__light_make_triangles(&render->scene->desc, m, light, lo, size);
}

PKTRT__COLD void pktrt__light_free_all(pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  for (uint32_t i = 0; render->lights && i < s->light_count; i++) {
    pktrt__mem_release(&s->desc, render->lights[i].triangles, render->lights[i].triangle_count,
                       sizeof(pktrt__light_triangle));
    pktrt__mem_release(&s->desc, render->lights[i].cdf, render->lights[i].triangle_count, sizeof(pktrt__light_cdf));
    pktrt__mem_release(&s->desc, render->lights[i].clusters, 2 * (uint64_t)render->lights[i].triangle_count,
                       sizeof(pktrt__light_cluster));
    pktrt__mem_release(&s->desc, render->lights[i].places, render->lights[i].triangle_count, sizeof(uint32_t));
  }
  pktrt__mem_release(&s->desc, render->lights, s->light_count, sizeof *render->lights);
  pktrt__mem_release(&s->desc, render->light_of_mesh, s->committed_meshes, sizeof *render->light_of_mesh);
  pktrt__mem_release(&s->desc, render->tree, 2 * (uint64_t)s->light_count, sizeof *render->tree);
  pktrt__mem_release(&s->desc, render->ordered, s->light_count, sizeof *render->ordered);
  if (render->environment != s->environment) pktrt__environment_free(&s->desc, render->environment);
  render->lights = NULL;
}

/* Describes a light as surfaces see it. A mesh stands in its middle in RCS and WRT: its projected area is |S cos| where
   it is flat, S being the sum of its area vectors; where it is closed and convex it is a quarter of the area on
   average, and S is 0. The shadow ray ends at the sphere around the mesh, whose own triangles would stop it. */
PKTRT__COLD void pktrt__light_describe(const pktrt__render_state *render, uint32_t index, pktrt__light_data *light) {
  const pktrt_light *l = &render->scene->lights[index];
  pktrt__light_target *target = &light->target;
  memset(target, 0, sizeof *target);
  target->flat = pktrt__light_has(l, PKTRT__LIGHT_FLAT), target->emissive = pktrt__light_has(l, PKTRT__LIGHT_EMISSIVE);
  target->radius = light->radius, target->area = light->area, target->strength = light->strength;
  target->near2 = light->near2;
  target->folded = pktrt__max(0, light->area - sqrt(pktrt__dot(light->facing, light->facing))) / 4;
  for (int a = 0; a < 3; a++) {
    target->facing[a] = light->facing[a], target->arriving[a] = light->color[a];
    target->at[a] = light->middle[a];
  }
  target->infinite = pktrt__light_has(l, PKTRT__LIGHT_INFINITE);
  target->by_square =
      pktrt__light_has(l, PKTRT__LIGHT_BY_SQUARE) && !(render->distribute && pktrt__light_has(l, PKTRT__LIGHT_AREA));
  target->lobes =
      pktrt__render_uses(render, PKTRT_FEATURE_GLOSS) && (light->both || !pktrt__light_has(l, PKTRT__LIGHT_HIT));
}

static bool pktrt__light_prepare_place(const pktrt__render_state *render, const pktrt_light *l,
                                       pktrt__light_data *light) {
  (void)render;
  for (int a = 0; a < 3; a++) light->middle[a] = (double)l->position[a];
  return true;
}

PKTRT__COLD bool pktrt__light_prepare_direction(const pktrt__render_state *render, const pktrt_light *l,
                                                pktrt__light_data *light) {
  (void)render;
  for (int a = 0; a < 3; a++) light->facing[a] = -(double)l->direction[a];
  (void)pktrt__normalise(light->facing);
  memcpy(light->middle, light->facing, sizeof light->middle);
  return true;
}

/* Returns the squared distance within which the solid angle of a parallelogram or triangle is worth the while: about one
   and a half times the radius of a circle around it. */
static double pktrt__light_near2(const double e0[3], const double e1[3]) {
  return 0.5 * (pktrt__dot(e0, e0) + pktrt__dot(e1, e1));
}
PKTRT__COLD bool pktrt__light_prepare_quad(const pktrt__render_state *render, const pktrt_light *l,
                                           pktrt__light_data *light) {
  double e[2][3];
  for (int a = 0; a < 6; a++) e[a / 3][a % 3] = (double)l->edge[a / 3][a % 3];
  (void)pktrt__light_prepare_place(render, l, light);
  for (int a = 0; a < 3; a++) light->middle[a] += 0.5 * e[0][a], light->middle[a] += 0.5 * e[1][a];
  pktrt__cross(e[0], e[1], light->facing);
  light->area = sqrt(pktrt__dot(light->facing, light->facing));
  light->near2 = pktrt__light_near2(e[0], e[1]);
  (void)pktrt__normalise(light->facing);
  return true;
}

PKTRT__NOINLINE double pktrt__distance2(const double a[3], const double b[3]) {
  const double d[3] = {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
  return pktrt__dot(d, d);
}

/* --- one light for all ---

   A tree over the lights that are not infinitely far, as over the triangles of a mesh: what `area` is there is the power here,
   as the area of a radiance of 1. Halves are weighed by power, distance and facing, as seen from each point; every half has
   some weight. Lights that are infinitely far count one each against all others together. */

static double pktrt__light_projected_area(const pktrt__light_cluster *, double along, double d);
PKTRT__COLD pktrt__environment *pktrt__environment_make(const pktrt_scene_desc *, const pktrt_render_desc *,
                                                        uint32_t rows);

/* Describes a light as the leaf of a tree. */
PKTRT__COLD void pktrt__light_leaf(const pktrt__render_state *render, uint32_t index, pktrt__light_cluster *c) {
  const pktrt_light *l = &render->scene->lights[index];
  const pktrt__light_data *light = &render->lights[index];
  double r = pktrt__light_has(l, PKTRT__LIGHT_ROUND) ? (double)l->radius : light->radius;
  memset(c, 0, sizeof *c);
  memcpy(c->middle, light->middle, sizeof c->middle);
  c->area = 4; /* a point */
  if (pktrt__light_has(l, PKTRT__LIGHT_ROUND)) c->area = 4 * PKTRT__PI * r * r;
  if (pktrt__light_has(l, PKTRT__LIGHT_FLAT | PKTRT__LIGHT_EMISSIVE)) c->area = light->area;
  c->area *= light->strength;
  c->bent = pktrt__light_has(l, PKTRT__LIGHT_FLAT) ? 0 : 1;
  for (int a = 0; a < 3 && c->bent <= 0; a++) {
    c->facing[a] = c->area * light->facing[a];
    r = pktrt__max(r, fabs((double)l->edge[0][a]) + fabs((double)l->edge[1][a]));
  }
  c->r2 = r * r;
}

/* Joins two clusters. */
PKTRT__COLD void pktrt__light_join(const pktrt__light_cluster *x, const pktrt__light_cluster *y,
                                   pktrt__light_cluster *c) {
  const double gap = sqrt(pktrt__distance2(x->middle, y->middle)), rx = sqrt(x->r2), ry = sqrt(y->r2);
  const double r = pktrt__max(pktrt__max(rx, ry), 0.5 * (gap + rx + ry)); /* the sphere around both */
  const double part = gap > 0 ? pktrt__min(pktrt__max((r - rx) / gap, 0), 1) : 0;
  double facing = 0;
  c->area = x->area + y->area;
  for (int a = 0; a < 3; a++) {
    c->middle[a] = x->middle[a] + part * (y->middle[a] - x->middle[a]), c->facing[a] = x->facing[a] + y->facing[a];
    facing += c->facing[a] * c->facing[a];
  }
  c->r2 = 1.000001 * r * r, c->bent = c->area > 0 ? pktrt__min(1, 2 * pktrt__max(0, 1 - sqrt(facing) / c->area)) : 0;
}
PKTRT__COLD void pktrt__light_make_tree(const pktrt__render_state *render, pktrt__light_cluster *to, uint32_t first,
                                        uint32_t n) {
  if (n == 1) {
    pktrt__light_leaf(render, render->ordered[first], to);
    return;
  }
  pktrt__light_make_tree(render, to + 1, first, n / 2);
  pktrt__light_make_tree(render, to + 2 * (n / 2), first + n / 2, n - n / 2);
  pktrt__light_join(to + 1, to + 2 * (n / 2), to);
}

/* Sorts the lights, near ones together, and makes a tree of them. False: out of memory. */
PKTRT__COLD bool pktrt__light_order(pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  const uint32_t n = s->light_count;
  double lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, size = 0;
  uint64_t *key = PKTRT__CAST(uint64_t *, pktrt__mem_alloc(&s->desc, n, sizeof *key));
  render->ordered = PKTRT__CAST(uint32_t *, pktrt__mem_alloc(&s->desc, n, sizeof *render->ordered));
  render->tree = PKTRT__CAST(pktrt__light_cluster *, pktrt__mem_alloc(&s->desc, 2 * (uint64_t)n, sizeof *render->tree));
  const bool ok = key && render->ordered && render->tree;
  for (uint32_t i = 0; i < 3 * n; i++) {
    const double x = render->lights[i / 3].middle[i % 3];
    if (pktrt__light_has(&s->lights[i / 3], PKTRT__LIGHT_INFINITE)) continue;
    lo[i % 3] = pktrt__min(lo[i % 3], x), hi[i % 3] = pktrt__max(hi[i % 3], x);
  }
  for (int a = 0; a < 3; a++) size = pktrt__max(size, hi[a] - lo[a]);
  for (uint32_t i = 0; ok && i < n; i++) {
    const bool infinite = pktrt__light_has(&s->lights[i], PKTRT__LIGHT_INFINITE);
    key[i] = infinite ? UINT64_MAX - n + i : pktrt__light_morton_key(render->lights[i].middle, lo, size) | i;
    render->finite += !infinite;
  }
  if (ok) pktrt__sort_keys(key, n);
  for (uint32_t i = 0; ok && i < n; i++)
    render->ordered[i] = i < render->finite ? (uint32_t)key[i] : (uint32_t)(key[i] - (UINT64_MAX - n));
  if (ok && render->finite) pktrt__light_make_tree(render, render->tree, 0, render->finite);
  pktrt__mem_release(&s->desc, key, n, sizeof *key);
  return ok;
}

/* Weighs what light of a cluster surfaces within `r2` of a point may get, as pktrt__light_weigh_cluster does, and less if
   it lies below. */
static double pktrt__light_weigh_for(const pktrt__light_cluster *c, const pktrt__light_view *from, double r2) {
  const double to[3] = {c->middle[0] - from->point[0], c->middle[1] - from->point[1], c->middle[2] - from->point[2]};
  const double d2 = pktrt__dot(to, to);
  if (!(d2 > 4 * (c->r2 + r2))) return c->area / pktrt__max(pktrt__max(d2, c->r2 + r2), 1e-200); /* a point: 0 */
  const double d = sqrt(d2), each = 1 / pktrt__max(d2, 1e-140), along = -pktrt__dot(to, c->facing);
  const double up = pktrt__dot(to, from->normal) + 0.75 * d;
  return (pktrt__light_projected_area(c, along, d) + c->area * d * (1.0 / 32)) *
         pktrt__min(d, pktrt__max(up, d * (1.0 / 32))) * (each * each);
}

/* Cuts the tree for surfaces within `r2` of a point: opens clusters that are near. WHY: what of them is seen is told by
   their parts alone, and a light close by would be chosen as rarely as all others of its cluster. */
static void pktrt__light_cut_tree(const pktrt__render_state *render, const pktrt__light_view *from, double r2,
                                  pktrt__light_cut *cut) {
  uint32_t at[PKTRT__LIGHT_CUT], first[PKTRT__LIGHT_CUT], n[PKTRT__LIGHT_CUT], top = 1, count = 0;
  double sum = 0;
  at[0] = first[0] = 0, n[0] = render->finite;
  while (top--) {
    const uint32_t i = at[top], begin = first[top], lights = n[top];
    const pktrt__light_cluster *c = &render->tree[i];
    const double x = from->point[0] - c->middle[0], y = from->point[1] - c->middle[1],
                 z = from->point[2] - c->middle[2];
    if (lights > 1 && x * x + y * y + z * z < 4 * (c->r2 + r2) && count + top + 2 <= PKTRT__LIGHT_CUT) {
      at[top] = i + 2 * (lights / 2), first[top] = begin + lights / 2, n[top++] = lights - lights / 2;
      at[top] = i + 1, first[top] = begin, n[top++] = lights / 2;
      continue;
    }
    cut->at[count] = i, cut->first[count] = begin, cut->n[count++] = lights;
  }
  for (uint32_t i = 0; i < count; i++) cut->sum[i] = sum += pktrt__light_weigh_for(&render->tree[cut->at[i]], from, r2);
  cut->count = count;
}

/* Returns the cut for a surface, from those that a tile has made. WHY by cells: neighbours share it, and what it is depends on
   where the surface is alone, not on who came before. */
static const pktrt__light_cut *pktrt__light_cut_for(const pktrt__render_state *render, const pktrt__light_view *from,
                                                    pktrt__light_cut *cuts) {
  const double size = sqrt(render->tree->r2) / 128, inverse = size > 0 ? 1 / size : 0;
  pktrt__light_view view;
  int32_t cell[4] = {0, 0, 0, 0};
  uint32_t hash = 0;
  memset(&view, 0, sizeof view);
  for (int a = 0; a < 3; a++) {
    const double x = (from->point[a] - render->tree->middle[a]) * inverse;
    cell[a] = (int32_t)pktrt__min(pktrt__max(x < 0 ? x - 1 : x, -1e9), 1e9);
    view.point[a] = render->tree->middle[a] + (cell[a] + 0.5) * size;
    hash = hash * 0x9E3779B1u + (uint32_t)cell[a];
    if (fabs(from->normal[a]) > fabs(from->normal[cell[3] / 2])) cell[3] = 2 * a;
  }
  const int axis = cell[3] / 2;
  if (from->normal[axis] < 0) cell[3]++;
  view.normal[axis] = from->normal[axis] < 0 ? -1 : 1;
  pktrt__light_cut *cut = &cuts[(hash ^ hash >> 15 ^ (uint32_t)cell[3] * 5) % PKTRT__LIGHT_CUTS];
  if (memcmp(cut->cell, cell, sizeof cell) != 0) {
    memcpy(cut->cell, cell, sizeof cell);
    pktrt__light_cut_tree(render, &view, 0.75 * size * size, cut);
  }
  return cut;
}

/* Where a choice of a light stands: at a cluster of n lights, the first of which lies at a place of `ordered`. */
typedef struct pktrt__light_descent {
  const pktrt__light_cluster *c;
  uint32_t first, n;
  double u, share; /* uniform in [0,1), and one over the probability so far */
} pktrt__light_descent;

/* Begins to choose a light for a surface by u in [0,1). */
static void pktrt__light_choose_part(const pktrt__render_state *render, pktrt__light_cut *cuts,
                                     const pktrt__light_view *from, double u, pktrt__light_descent *to) {
  const uint32_t infinite = render->scene->light_count - render->finite, ways = infinite + (render->finite > 0);
  const uint32_t way = (uint32_t)(u * ways) < ways ? (uint32_t)(u * ways) : ways - 1;
  to->c = NULL, to->first = render->finite + way, to->n = 1, to->share = ways;
  if (way < infinite) return;
  const pktrt__light_cut *cut = pktrt__light_cut_for(render, from, cuts);
  const double all = cut->sum[cut->count - 1], want = (u * ways - infinite) * all;
  uint32_t i = 0;
  for (uint32_t step = PKTRT__LIGHT_CUT / 2; step; step /= 2)
    if (i + step < cut->count && cut->sum[i + step - 1] <= want) i += step;
  const double before = i ? cut->sum[i - 1] : 0, part = cut->sum[i] - before;
  to->c = &render->tree[cut->at[i]], to->first = cut->first[i], to->n = cut->n[i];
  to->u = part > 0 ? (want - before) / part : 0, to->share *= part > 0 ? all / part : cut->count;
}

/* Chooses the half of a cluster in which it goes on, without branches: nothing foretells which. */
static void pktrt__light_choose_half(const pktrt__light_view *from, pktrt__light_descent *at) {
  const uint32_t half = at->n / 2;
  const double left = pktrt__light_weigh_for(at->c + 1, from, 0),
               weight[2] = {left, pktrt__light_weigh_for(at->c + 2 * half, from, 0)};
  const double both = left + weight[1], t = at->u * both;
  const uint32_t right = !(t < left);
  const double inverse = 1 / pktrt__max(weight[right], DBL_MIN);
  at->share *= both * inverse, at->u = (t - right * left) * inverse;
  at->c += 1 + right * (2 * half - 1), at->first += right * half, at->n = half + right * (at->n - 2 * half);
}

/* Tells whether rays of lobes share what they find of a light with its samples: if that is the same light. */
PKTRT__COLD bool pktrt__light_is_found(const pktrt__render_state *render, uint32_t index) {
  const pktrt_light *l = &render->scene->lights[index];
  const pktrt_material *mat = NULL;
  bool first = true;
  if (!render->distribute || !render->follow || !pktrt__render_uses(render, PKTRT_FEATURE_GLOSS) ||
      !pktrt__light_has(l, PKTRT__LIGHT_HIT))
    return false;
  if (pktrt__light_has(l, PKTRT__LIGHT_EMISSIVE))
    mat = pktrt__material_of(render->scene, render->scene->meshes[l->mesh].material);
  for (uint32_t i = 0; i < index; i++) {
    const pktrt_light *other = &render->scene->lights[i];
    first = first && (other->kind != l->kind || (mat && other->mesh != l->mesh));
  }
  const bool plain = l->intensity[0] == 1 && l->intensity[1] == 1 && l->intensity[2] == 1;
  return first && plain && !(mat && (mat->texture || mat->shader));
}

/* Finds out how lobes find lights that rays hit. False: out of memory. */
PKTRT__COLD bool pktrt__light_link(pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  for (uint32_t i = 0; i < s->light_count; i++) {
    const pktrt_light *l = &s->lights[i];
    pktrt__light_data *light = &render->lights[i];
    light->both = pktrt__light_is_found(render, i);
    render->two_ways = render->two_ways || light->both || pktrt__light_rows[l->kind].meet;
    if (!light->both) continue;
    if (!pktrt__light_has(l, PKTRT__LIGHT_EMISSIVE)) { /* by cosine alone it would share noise, and gain nothing */
      light->both = render->environment && render->environment->share > 0;
      if (light->both) render->sky_light = i;
      continue;
    }
    if (!render->light_of_mesh) {
      render->light_of_mesh =
          PKTRT__CAST(uint32_t *, pktrt__mem_alloc(&s->desc, s->committed_meshes, sizeof *render->light_of_mesh));
      if (!render->light_of_mesh) return false;
      memset(render->light_of_mesh, 0xFF, s->committed_meshes * sizeof *render->light_of_mesh); /* PKTRT_NONE */
    }
    light->places = PKTRT__CAST(uint32_t *, pktrt__mem_alloc(&s->desc, light->triangle_count, sizeof *light->places));
    if (!light->places) return false;
    for (uint32_t k = 0; k < light->triangle_count; k++) light->places[light->triangles[k].triangle] = k;
    render->light_of_mesh[l->mesh] = i;
  }
  return true;
}

/* Prepares the environment to be drawn from, if it is a light. False: out of memory. */
PKTRT__COLD bool pktrt__light_prepare_environment(pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  const pktrt_render_desc *d = render->desc;
  bool lit = false;
  for (uint32_t i = 0; i < s->light_count; i++) lit = lit || s->lights[i].kind == PKTRT_LIGHT_ENVIRONMENT;
  if (!PKTRT__AREA_LIGHTS || !lit || !d->environment || !render->distribute) return true;
  const bool prepared = s->environment && s->environment->radiance == d->environment && s->environment->user == d->user;
  const uint64_t passes = d->passes ? d->passes : 1,
                 samples = (uint64_t)d->width * d->height * render->samples * passes;
  const uint32_t rows = samples < 1 << 14 ? 128 : 512; /* with fewer cells a small sun is missed */
  render->environment = prepared ? s->environment : pktrt__environment_make(&s->desc, d, rows);
  return render->environment != NULL;
}

PKTRT__COLD bool pktrt__light_make_all(pktrt__render_state *render) { /* false: out of memory, and none are left */
  const pktrt_scene *s = render->scene;
  bool ok = true;
  render->lights = PKTRT__CAST(pktrt__light_data *, pktrt__mem_alloc(&s->desc, s->light_count, sizeof *render->lights));
  if (!render->lights) return false;
  memset(render->lights, 0, s->light_count * sizeof *render->lights);
  for (uint32_t i = 0; ok && i < s->light_count; i++) {
    const pktrt_light *l = &s->lights[i];
    pktrt__light_data *light = &render->lights[i];
    const bool emissive = pktrt__light_has(l, PKTRT__LIGHT_EMISSIVE);
    const pktrt_material *mat = emissive ? pktrt__material_of(s, s->meshes[l->mesh].material) : NULL;
    double emitted[3];
    for (int a = 0; a < 3; a++) {
      emitted[a] = (double)l->intensity[a] * (mat ? (double)mat->emission[a] : 1);
      light->strength = pktrt__max(emitted[a], light->strength);
    }
    for (int a = 0; a < 3; a++) light->color[a] = light->strength > 0 ? (float)(emitted[a] / light->strength) : 0;
    ok = pktrt__light_rows[l->kind].prepare(render, l, light);
  }
  ok = ok && pktrt__light_prepare_environment(render) && pktrt__light_link(render);
  for (uint32_t i = 0; i < s->light_count; i++)
    render->shown = render->shown || (s->lights[i].visible && pktrt__light_rows[s->lights[i].kind].meet);
  if (ok && (render->shown || (s->light_count && render->distribute && render->desc->lights != PKTRT_LIGHTS_ALL)))
    ok = pktrt__light_order(render);
  for (uint32_t i = 0; ok && i < s->light_count; i++) pktrt__light_describe(render, i, &render->lights[i]);
  if (!ok) pktrt__light_free_all(render);
  return ok;
}
static double pktrt__light_sample_middle(const pktrt__render_state *render, uint32_t light, const float u[2],
                                         const pktrt__light_view *from, double at[3]) {
  (void)u, (void)from;
  memcpy(at, render->lights[light].middle, 3 * sizeof *at);
  return 1;
}

/* --- by solid angle ---

   Next to a light the irradiance of its points goes to infinity with 1 / r^2, and with it the variance of points that
   are uniform by area. Points that are uniform by the solid angle in which they are seen all bring the same.

   Let A, B, C be the unit vectors to the corners of a triangle. Its solid angle S has (Van Oosterom and Strackee 1983)

       tan(S / 2) = |det(A, B, C)| / (1 + A.B + B.C + C.A).

   A part u of it is seen between B A and B D, D on the arc from A to C (Arvo 1995). With g = (|det|, A.C + B.C, 1 + A.B)
   and c, s the cosine and sine of u S / 2, D is A mirrored at (g0 c - g1 s) A + g2 s C (Peters 2021), which needs no
   angle of the triangle, and loses nothing where it is small. On the arc from B to D a point whose 1 - cos is v times that
   of D takes a part v of what is between. So u turns an arc about B, and v goes along it: neighbours stay neighbours.

   A rectangle is mapped along its edges (Urena, Fajardo and King 2013), which keeps strata better: for smooth light half
   the error. In a frame with axes along the edges and z to the point, its corners have coordinates x0, x1, y0, y1 and -h.
   The planes through the point and the edges have normals whose z are, edge by edge around,
   n = (-y0, x1, y1, -x0) / sqrt(itself^2 + h^2), and each corner is the angle arccos(-n_i n_i+1) between two of these; the
   four, less 2 pi, are S. (They are added as products of complex numbers on the unit circle, which takes one angle in
   place of four.) A part u of S has x below f: with b = u S + 2 pi minus the last two angles,

       f = (cos b n_0 - n_2) / sin b, the x cut at h c / sqrt(1 - c^2), c = sign(f) / sqrt(f^2 + n_0^2);

   and y is where y / sqrt(x^2 + y^2 + h^2) goes evenly from one side to the other. Any other parallelogram is a fan of two
   triangles about one corner, which the arc sweeps one after the other. */

typedef struct pktrt__solid_angle {
  double a[3], b[3], c[3], g[3]; /* as above */
  double angle;
} pktrt__solid_angle;

/* Fills in one of a triangle with corners relative to a point and their determinant. Returns the angle. */
static double pktrt__solid_angle_of(const double a[3], const double b[3], const double c[3], double det,
                                    pktrt__solid_angle *s) {
  const double *const from[3] = {a, b, c};
  double *const to[3] = {s->a, s->b, s->c}, size = fabs(det);
  s->angle = 0;
  for (int i = 0; i < 3; i++) {
    const double length = sqrt(pktrt__dot(from[i], from[i]));
    if (!(length > 0)) return 0;
    for (int k = 0; k < 3; k++) to[i][k] = from[i][k] / length;
    size /= length;
  }
  s->g[0] = size, s->g[1] = pktrt__dot(s->a, s->c) + pktrt__dot(s->b, s->c), s->g[2] = 1 + pktrt__dot(s->a, s->b);
  return s->angle = 2 * pktrt__math_angle(s->g[0], s->g[1] + s->g[2]);
}

/* Computes the direction of unit length that u, v in [0,1] take. */
static void pktrt__solid_angle_sample(const pktrt__solid_angle *s, double u, double v, double out[3]) {
  double sine, cosine, half[3], d[3], rise = 0;
  pktrt__math_sincos_turn(u * s->angle / (4 * PKTRT__PI), &sine, &cosine);
  const double x = s->g[0] * cosine - s->g[1] * sine, y = s->g[2] * sine;
  for (int k = 0; k < 3; k++) half[k] = x * s->a[k] + y * s->c[k];
  const double along = 2 * pktrt__dot(s->a, half) / pktrt__max(pktrt__dot(half, half), DBL_MIN);
  for (int k = 0; k < 3; k++) d[k] = along * half[k] - s->a[k], rise += 0.5 * (d[k] - s->b[k]) * (d[k] - s->b[k]);
  const double part = rise < 2 ? sqrt(v * (2 - v * rise) / (2 - rise)) : 0, rest = 1 - v * rise - part * (1 - rise);
  for (int k = 0; k < 3; k++) out[k] = rest * s->b[k] + part * d[k];
}

/* Returns how far from a plane a point may come by rounding: it sees nothing of what it lies in. */
static double pktrt__light_least_height(const double from[3]) {
  return 16 * PKTRT__ERROR_PLANE * (fabs(from[0]) + fabs(from[1]) + fabs(from[2]));
}

/* How a quad is seen. */
typedef struct pktrt__light_quad {
  double edge[2][3], to[3], height; /* to its corner; of the point over its plane */
  double angle;                     /* 0: it is sampled by area */
  bool right;                       /* it is a rectangle: */
  double length[2], low[2];         /* of its edges; x0 and y0 */
  double n[2], last[2];             /* n_0 and n_2 as above; cosine and sine of the last two angles together */
  pktrt__solid_angle half[2];       /* else */
} pktrt__light_quad;

PKTRT__COLD void pktrt__light_look_at_rectangle(pktrt__light_quad *q) {
  double n[4], c[4], s[4];
  for (int i = 0; i < 2; i++) q->low[i] = pktrt__dot(q->to, q->edge[i]) / q->length[i];
  n[0] = -q->low[1], n[1] = q->low[0] + q->length[0], n[2] = q->low[1] + q->length[1], n[3] = -q->low[0];
  for (int i = 0; i < 4; i++) n[i] /= sqrt(n[i] * n[i] + q->height * q->height);
  for (int i = 0; i < 4; i++) c[i] = -n[i] * n[(i + 1) % 4], s[i] = sqrt(pktrt__max(0, (1 - c[i]) * (1 + c[i])));
  const double x = c[0] * c[1] - s[0] * s[1], y = c[0] * s[1] + s[0] * c[1];
  q->last[0] = c[2] * c[3] - s[2] * s[3], q->last[1] = c[2] * s[3] + s[2] * c[3];
  const double sine = x * q->last[1] + y * q->last[0];
  q->angle = pktrt__math_angle(fabs(sine), x * q->last[0] - y * q->last[1]);
  /* more than a half only from before the rectangle; else that is rounding */
  if (sine < 0) q->angle = n[0] > 0 && n[1] > 0 && n[2] > 0 && n[3] > 0 ? 2 * PKTRT__PI - q->angle : 0;
  if (!(q->angle > 1e-6)) q->angle = 0;
  q->n[0] = n[0], q->n[1] = n[2];
}

/* Looks at a quad that is near. */
PKTRT__COLD void pktrt__light_look_closely_at_quad(const pktrt__light_data *light, pktrt__light_quad *q) {
  double corner[3][3];
  for (int i = 0; i < 2; i++) q->length[i] = sqrt(pktrt__dot(q->edge[i], q->edge[i]));
  q->right = fabs(pktrt__dot(q->edge[0], q->edge[1])) <= 1e-6 * q->length[0] * q->length[1];
  if (q->right) {
    pktrt__light_look_at_rectangle(q);
    return;
  }
  for (int a = 0; a < 3; a++) {
    corner[0][a] = q->to[a] + q->edge[0][a], corner[1][a] = corner[0][a] + q->edge[1][a];
    corner[2][a] = q->to[a] + q->edge[1][a];
  }
  for (int i = 0; i < 2; i++)
    q->angle += pktrt__solid_angle_of(corner[i], q->to, corner[i + 1], q->height * light->area, &q->half[i]);
}
/* Looks at a quad from a point. False: from behind. */
PKTRT__INLINE bool pktrt__light_look_at_quad(const pktrt__render_state *render, uint32_t index, const double from[3],
                                             pktrt__light_quad *q) {
  const pktrt_light *l = &render->scene->lights[index];
  const pktrt__light_data *light = &render->lights[index];
  for (int a = 0; a < 3; a++) {
    q->edge[0][a] = (double)l->edge[0][a], q->edge[1][a] = (double)l->edge[1][a];
    q->to[a] = (double)l->position[a] - from[a];
  }
  q->height = -pktrt__dot(q->to, light->facing), q->angle = 0;
  if (!(q->height > pktrt__light_least_height(from))) return false;
  if (pktrt__distance2(from, light->middle) < light->near2) pktrt__light_look_closely_at_quad(light, q);
  return true;
}

/* Returns one over the density of a point of a quad. */
static double pktrt__light_quad_spread(const pktrt__light_quad *q, double area, const double from[3],
                                       const double at[3]) {
  const double d[3] = {at[0] - from[0], at[1] - from[1], at[2] - from[2]}, r2 = pktrt__dot(d, d);
  return q->angle > 0 ? q->angle : area * q->height / (r2 * sqrt(r2));
}

/* Turns u in [0,1)^2 to coordinates on a rectangle, in units of its edges. */
static void pktrt__light_map_rectangle(const pktrt__light_quad *q, double u, double v, double out[2]) {
  double sine, cosine, end[2];
  const double h = q->height, *low = q->low;
  double s, c;
  pktrt__math_sincos_turn(u * q->angle / (2 * PKTRT__PI), &s, &c);
  sine = s * q->last[0] - c * q->last[1], cosine = c * q->last[0] + s * q->last[1];
  const double f = cosine * q->n[0] - q->n[1], c2 = sine * sine / (f * f + sine * sine * q->n[0] * q->n[0]);
  double x = h * sqrt(c2 / pktrt__max(1 - c2, DBL_MIN));
  x = pktrt__min(pktrt__max((f < 0) != (sine < 0) ? -x : x, low[0]), low[0] + q->length[0]);
  const double d2 = x * x + h * h;
  for (int i = 0; i < 2; i++) {
    const double y = low[1] + i * q->length[1];
    end[i] = y / sqrt(d2 + y * y);
  }
  const double part = end[0] + v * (end[1] - end[0]), y = part * sqrt(d2 / pktrt__max(1 - part * part, DBL_MIN));
  out[0] = (x - low[0]) / q->length[0];
  out[1] = pktrt__min(pktrt__max((y - low[1]) / q->length[1], 0), 1);
}

static double pktrt__light_sample_quad(const pktrt__render_state *render, uint32_t index, const float u[2],
                                       const pktrt__light_view *from, double at[3]) {
  const double x = (double)u[0], y = (double)u[1];
  double d[3], part[2] = {x, y};
  pktrt__light_quad q;
  if (!pktrt__light_look_at_quad(render, index, from->point, &q)) return 0;
  if (q.angle > 0 && !q.right) {
    const double want = x * q.angle;
    const pktrt__solid_angle *half = &q.half[want < q.half[0].angle || !(q.half[1].angle > 0) ? 0 : 1];
    const double before = half == q.half ? 0 : q.half[0].angle;
    pktrt__solid_angle_sample(half, pktrt__min(1, (want - before) / half->angle), y, d);
    const double along = -pktrt__dot(d, render->lights[index].facing);
    for (int a = 0; a < 3; a++) at[a] = from->point[a] + q.height / along * d[a];
    return along > 0 ? q.angle : 0;
  }
  if (q.angle > 0) pktrt__light_map_rectangle(&q, x, y, part);
  for (int a = 0; a < 3; a++) at[a] = from->point[a] + q.to[a] + (part[0] * q.edge[0][a] + part[1] * q.edge[1][a]);
  return pktrt__light_quad_spread(&q, render->lights[index].area, from->point, at);
}
PKTRT__COLD double pktrt__light_meet_quad(const pktrt__render_state *render, uint32_t index,
                                          const pktrt__light_view *from, const double direction[3], double at[3]) {
  const pktrt__light_data *light = &render->lights[index];
  pktrt__light_quad q;
  double across[3], turned[3];
  const double along = -pktrt__dot(direction, light->facing);
  if (!(along > 0) || !pktrt__light_look_at_quad(render, index, from->point, &q)) return 0;
  /* q.to + x e0 + y e1 is on the ray: both are quotients of volumes */
  pktrt__cross(direction, q.edge[1], across), pktrt__cross(q.edge[0], q.to, turned);
  const double volume = pktrt__dot(q.edge[0], across), x = -pktrt__dot(q.to, across) / volume,
               y = pktrt__dot(direction, turned) / volume;
  if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1)) return 0;
  for (int a = 0; a < 3; a++) at[a] = from->point[a] + q.height / along * direction[a];
  return pktrt__light_quad_spread(&q, light->area, from->point, at);
}

/* Samples uniformly the cone of directions in which the sphere is seen, of solid angle 2 pi (1 - cos), whose largest
   angle has the sine R / distance; from within, all directions. Its middle, in the other modes, has the exact irradiance
   pi R^2 / distance^2; these modes have no direction to take within. */
static double pktrt__light_sample_sphere(const pktrt__render_state *render, uint32_t index, const float u[2],
                                         const pktrt__light_view *from, double at[3]) {
  const pktrt_light *l = &render->scene->lights[index];
  double axis[3], disk[2], to[3], d2 = 0;
  const double radius = (double)l->radius;
  for (int a = 0; a < 3; a++) axis[a] = (double)l->position[a] - from->point[a], d2 += axis[a] * axis[a];
  const double distance = sqrt(d2), s2 = radius * radius / d2;
  if (!(radius > 0) || (!u && !(s2 < 1))) return 0;
  if (!(s2 < 1)) {
    float d[3];
    pktrt_map_sphere(u, d);
    for (int a = 0; a < 3; a++) to[a] = (double)d[a];
    return pktrt__light_meet_sphere(render, index, from, to, at);
  }
  for (int a = 0; a < 3; a++) axis[a] /= distance;
  if (!u) {
    for (int a = 0; a < 3; a++) at[a] = from->point[a] + (distance - radius) * axis[a];
    return PKTRT__PI * s2;
  }
  pktrt__map_to_disk(u, disk);
  const double x = disk[0], y = disk[1], rise = s2 / (1 + sqrt(1 - s2)); /* 1 - cos */
  const double down = (x * x + y * y) * rise, cosine = 1 - down, sine = sqrt(rise * (1 + cosine));
  const double sin2 = down * (1 + cosine);
  const double depth = distance * cosine - sqrt(pktrt__max(0, radius * radius - d2 * sin2));
  pktrt__map_along(axis, sine * x, sine * y, cosine, to);
  for (int a = 0; a < 3; a++) at[a] = from->point[a] + depth * to[a];
  return 2 * PKTRT__PI * rise;
}
PKTRT__COLD double pktrt__light_meet_sphere(const pktrt__render_state *render, uint32_t index,
                                            const pktrt__light_view *from, const double direction[3], double at[3]) {
  const pktrt_light *l = &render->scene->lights[index];
  double to[3], aside[3];
  const double r2 = (double)l->radius * (double)l->radius;
  for (int a = 0; a < 3; a++) to[a] = (double)l->position[a] - from->point[a];
  const double d2 = pktrt__dot(to, to), along = pktrt__dot(to, direction);
  const bool outside = d2 > r2;
  for (int a = 0; a < 3; a++) aside[a] = to[a] - along * direction[a];
  const double rest = r2 - pktrt__dot(aside, aside); /* of half the chord, squared */
  if (!(rest > 0) || (outside && !(along > 0))) return 0;
  const double depth = outside ? (d2 - r2) / (along + sqrt(rest)) : along + sqrt(rest);
  for (int a = 0; a < 3; a++) at[a] = from->point[a] + depth * direction[a];
  const double s2 = outside ? r2 / d2 : 1;
  return outside ? 2 * PKTRT__PI * s2 / (1 + sqrt(1 - s2)) : 4 * PKTRT__PI;
}

/* Tells whether a ray with a direction of unit length meets the sphere around a cluster of lights, before a depth. */
static bool pktrt__light_may_meet(const pktrt__light_cluster *c, const double from[3], const double direction[3],
                                  double depth) {
  const double to[3] = {c->middle[0] - from[0], c->middle[1] - from[1], c->middle[2] - from[2]};
  const double along = pktrt__dot(to, direction), d2 = pktrt__dot(to, to), r2 = 1.000001 * c->r2;
  return d2 <= r2 || (along > 0 && d2 - along * along <= r2 + 1e-12 * d2 && along - sqrt(r2) < depth);
}

/* Finds the first visible light that a ray meets before a depth, which becomes that of the light; or PKTRT_NONE. */
PKTRT__COLD uint32_t pktrt__light_see(const pktrt__render_state *render, const double from[3],
                                      const double direction[3], double *depth) {
  struct {
    uint32_t at, first, n;
  } stack[34] = {{0, 0, render->finite}};
  uint32_t seen = PKTRT_NONE;
  pktrt__light_view view;
  memset(&view, 0, sizeof view);
  memcpy(view.point, from, sizeof view.point);
  for (uint32_t top = render->finite ? 1 : 0; top--;) {
    const uint32_t at = stack[top].at, first = stack[top].first, n = stack[top].n, light = render->ordered[first];
    double found[3];
    if (!pktrt__light_may_meet(&render->tree[at], from, direction, *depth)) continue;
    if (n > 1) {
      stack[top].at = at + 1, stack[top].first = first, stack[top++].n = n / 2;
      stack[top].at = at + 2 * (n / 2), stack[top].first = first + n / 2, stack[top++].n = n - n / 2;
      continue;
    }
    const pktrt_light *l = &render->scene->lights[light];
    if (!l->visible || !pktrt__light_rows[l->kind].meet ||
        !(pktrt__light_rows[l->kind].meet(render, light, &view, direction, found) > 0))
      continue;
    const double away = sqrt(pktrt__distance2(from, found));
    if (away < *depth || (away <= *depth && light < seen)) *depth = away, seen = light;
  }
  return seen;
}

/* --- the environment --- */

/* Returns the cell of a table that a direction falls to. */
static uint32_t pktrt__environment_cell(const pktrt__environment *e, const double d[3]) {
  const double angle = pktrt__math_angle(sqrt(d[0] * d[0] + d[2] * d[2]), d[1]) / PKTRT__PI;
  const double turn = pktrt__math_angle(fabs(d[2]), d[0]) / (2 * PKTRT__PI);
  uint32_t row = (uint32_t)(angle * e->rows), column = (uint32_t)((d[2] < 0 ? 1 - turn : turn) * 2 * e->rows);
  row = row < e->rows ? row : e->rows - 1, column = column < 2 * e->rows ? column : 2 * e->rows - 1;
  while (row > 0 && d[1] > e->edge[row]) row--;
  while (row + 1 < e->rows && d[1] < e->edge[row + 1]) row++;
  return row * 2 * e->rows + column;
}

/* Returns what entry i adds to sums. */
static double pktrt__environment_part(const float *sum, uint32_t i) {
  return i ? (double)sum[i] - (double)sum[i - 1] : (double)sum[0];
}

/* Returns the density, by solid angle, of samples of an environment. */
static double pktrt__light_environment_density(const pktrt__render_state *render, const pktrt__light_view *from,
                                               const double d[3]) {
  const pktrt__environment *e = render->environment;
  const double cosine = pktrt__max(0, pktrt__dot(d, from->normal)) / PKTRT__PI;
  if (!e || !(e->share > 0)) return cosine;
  const uint32_t columns = 2 * e->rows, cell = pktrt__environment_cell(e, d), row = cell / columns;
  const double all = (double)e->along[row * columns + columns - 1];
  const double part = all > 0 ? pktrt__environment_part(e->along + (size_t)row * columns, cell % columns) / all : 0;
  const double of_row = (e->sum[row] - (row ? e->sum[row - 1] : 0)) / e->sum[e->rows - 1];
  const double size = (e->edge[row] - e->edge[row + 1]) * 2 * PKTRT__PI / columns;
  return (1 - e->share) * cosine + e->share * of_row * part / size;
}

/* Draws a direction from a table. */
PKTRT__COLD void pktrt__environment_draw(const pktrt__environment *e, double u, double v, double d[3]) {
  const uint32_t columns = 2 * e->rows;
  const double want = u * e->sum[e->rows - 1];
  double sine, cosine;
  uint32_t row = 0, column = 0;
  for (uint32_t step = e->rows / 2; step; step /= 2) /* rows and columns are powers of two */
    if (e->sum[row + step - 1] <= want) row += step;
  const float *along = e->along + (size_t)row * columns;
  const double at = v * (double)along[columns - 1];
  for (uint32_t step = columns / 2; step; step /= 2)
    if ((double)along[column + step - 1] <= at) column += step;
  const double before = row ? e->sum[row - 1] : 0, part = pktrt__environment_part(along, column);
  const double down = pktrt__min(1, (want - before) / (e->sum[row] - before));
  const double rest = part > 0 ? (at - ((double)along[column] - part)) / part : 0;
  d[1] = e->edge[row] + down * (e->edge[row + 1] - e->edge[row]);
  pktrt__math_sincos_turn((column + pktrt__min(1, rest)) / columns, &sine, &cosine);
  const double wide = sqrt(pktrt__max(0, (1 - d[1]) * (1 + d[1])));
  d[0] = wide * cosine, d[2] = wide * sine;
}

/* Samples directions over the hemisphere by their cosine, and where the environment is far brighter than in the mean, from
   its table: the density is that of both together. */
static double pktrt__light_sample_environment(const pktrt__render_state *render, uint32_t index, const float u[2],
                                              const pktrt__light_view *from, double at[3]) {
  const pktrt__environment *e = render->environment;
  const double share = e ? e->share : 0;
  (void)index;
  if (u && (double)u[0] < share) {
    pktrt__environment_draw(e, (double)u[0] / share, (double)u[1], at);
  } else { /* the normal itself, where nothing is random */
    const float part[2] = {u ? (float)(((double)u[0] - share) / (1 - share)) : 0, u ? u[1] : 0};
    pktrt__map_cosine_lobe(part, from->normal, at);
  }
  const double density =
      u ? pktrt__light_environment_density(render, from, at) : pktrt__dot(at, from->normal) / PKTRT__PI;
  return density > 0 ? 1 / density : 0;
}

/* Fills 64 columns of a table with radiance, summed over channels: what is not a positive number counts as none. */
PKTRT__NOINLINE void pktrt__environment_look(const pktrt__environment *e, uint32_t first, float *to) {
  const uint32_t columns = 2 * e->rows;
  double sine[64], cosine[64];
  for (uint32_t k = 0; k < 64; k++) pktrt__math_sincos_turn((first + k + 0.5) / columns, &sine[k], &cosine[k]);
  for (uint32_t row = 0; row < e->rows; row++, to += columns) {
    float d[3][64], radiance[3][64];
    double high, low;
    pktrt__math_sincos_turn((row + 0.5) / columns, &high, &low);
    for (uint32_t k = 0; k < 64; k++)
      d[0][k] = (float)(high * cosine[k]), d[1][k] = (float)low, d[2][k] = (float)(high * sine[k]);
    const float *const from[3] = {d[0], d[1], d[2]};
    float *const into[3] = {radiance[0], radiance[1], radiance[2]};
    e->radiance(e->user, 64, from, into);
    for (uint32_t k = 0; k < 64; k++) {
      const float sum = radiance[0][k] + radiance[1][k] + radiance[2][k];
      to[first + k] = sum > 0 && sum < 1e30f ? sum : 0;
    }
  }
}

/* Makes sums of what a table of radiance has beyond twice the mean. Cells count at least a quarter of their neighbours: a
   small sun may lie partly in a cell whose middle it misses. */
PKTRT__NOINLINE void pktrt__environment_sum(pktrt__environment *e, const float *radiance) {
  const uint32_t columns = 2 * e->rows;
  double all = 0, beyond = 0;
  for (uint32_t row = 0; row < e->rows; row++) {
    double sum = 0;
    for (uint32_t i = 0; i < columns; i++) sum += (double)radiance[row * columns + i];
    all += sum * (e->edge[row] - e->edge[row + 1]);
  }
  all /= columns; /* now twice the mean: the edges' differences sum up to 2 */
  for (uint32_t row = 0; row < e->rows; row++) {
    const float *at = radiance + row * columns, *above = row ? at - columns : at,
                *below = row + 1 < e->rows ? at + columns : at;
    float *to = e->along + row * columns, most[3] = {0, 0, 0}; /* of three rows: the columns before, here, behind */
    double sum = 0;
    for (uint32_t i = columns - 2; i < 2 * columns; i++) {
      const uint32_t x = (i + 1) % columns;
      most[0] = most[1], most[1] = most[2], most[2] = pktrt__maxf(at[x], pktrt__maxf(above[x], below[x]));
      if (i < columns) continue;
      const float here = pktrt__maxf(4 * at[i - columns], pktrt__maxf(most[0], pktrt__maxf(most[1], most[2])));
      sum += pktrt__max(0, 0.25 * (double)here - all);
      to[i - columns] = (float)sum;
    }
    beyond += sum * (e->edge[row] - e->edge[row + 1]), e->sum[row] = beyond;
  }
  e->share = beyond > 0 ? pktrt__min(0.9, beyond / (beyond + 0.5 * all * columns)) : 0;
  if (e->share < 1.0 / 32) e->share = 0;
}

PKTRT__COLD void pktrt__environment_free(const pktrt_scene_desc *desc, pktrt__environment *e) {
  if (!e) return;
  pktrt__mem_release(desc, e->edge, e->rows + 1, sizeof *e->edge);
  pktrt__mem_release(desc, e->sum, e->rows, sizeof *e->sum);
  pktrt__mem_release(desc, e->along, 2 * (uint64_t)e->rows * e->rows, sizeof *e->along);
  pktrt__mem_release(desc, e, 1, sizeof *e);
}
/* Makes the table of a render's environment, of 2 rows^2 cells; NULL: out of memory. */
PKTRT__COLD pktrt__environment *pktrt__environment_make(const pktrt_scene_desc *desc, const pktrt_render_desc *d,
                                                        uint32_t rows) {
  pktrt__environment *e = PKTRT__CAST(pktrt__environment *, pktrt__mem_alloc(desc, 1, sizeof *e));
  if (!e) return NULL;
  e->rows = rows;
  e->radiance = d->environment, e->user = d->user, e->share = 0;
  const uint64_t cells = 2 * (uint64_t)e->rows * e->rows;
  float *radiance = PKTRT__CAST(float *, pktrt__mem_alloc(desc, cells, sizeof *radiance));
  e->edge = PKTRT__CAST(double *, pktrt__mem_alloc(desc, e->rows + 1, sizeof *e->edge));
  e->sum = PKTRT__CAST(double *, pktrt__mem_alloc(desc, e->rows, sizeof *e->sum));
  e->along = PKTRT__CAST(float *, pktrt__mem_alloc(desc, cells, sizeof *e->along));
  const bool ok = radiance && e->edge && e->sum && e->along;
  for (uint32_t i = 0; ok && i <= e->rows; i++) {
    double sine;
    pktrt__math_sincos_turn(i / (2.0 * e->rows), &sine, &e->edge[i]);
  }
  for (uint32_t i = 0; ok && i < 2 * e->rows; i += 64) pktrt__environment_look(e, i, radiance);
  if (ok) pktrt__environment_sum(e, radiance);
  pktrt__mem_release(desc, radiance, cells, sizeof *radiance);
  if (ok) return e;
  pktrt__environment_free(desc, e);
  return NULL;
}

/* Estimates the projected area of a cluster whose area vectors have the sum s, as seen from afar: max(0, s.d) if it is
   flat; of a ball or half of one, a quarter of the area and half of s.d. Everything times the distance. */
static double pktrt__light_projected_area(const pktrt__light_cluster *c, double along, double d) {
  return (1 - c->bent) * pktrt__max(0, along) + c->bent * pktrt__max(0, 0.25 * c->area * d + 0.5 * along);
}

/* Estimates how much light of a cluster arrives at a point, as a fraction: its area, as seen from there, over the
   squared distance of its middle. What looks away counts less by `back`, and 1/32 makes sure that nothing is left out.
   Near by, where facings say little, it counts whole, as if it were as far as its radius or, thin clusters, less far:
   light of triangles next to the point, which rises with 1 / r^2, does not come in rare large pieces. */
static double pktrt__light_weigh_cluster(const pktrt__light_cluster *c, const double from[3], double d2, double back,
                                         double *over) {
  *over = pktrt__max(d2, c->r2);
  if (d2 < 4 * c->r2) {
    *over = sqrt(*over * pktrt__max(d2, pktrt__min(c->r2, 0.25 * c->area)));
    return c->area;
  }
  const double to[3] = {from[0] - c->middle[0], from[1] - c->middle[1], from[2] - c->middle[2]}, d = sqrt(d2);
  const double along = pktrt__dot(to, c->facing);
  *over *= d;
  return pktrt__light_projected_area(c, along, d) + back * pktrt__light_projected_area(c, -along, d) + c->area * d / 32;
}

/* Finds a triangle of a light, as seen from a point: that which u in [0,1) falls to, and u becomes uniform again; or with u
   NULL looks at place `to`. Returns its place; *inverse is one over its probability. Goes cluster by cluster, until one is
   far and nearly flat, and by area in there; by area alone if they move. WHY: pool hall, 16 samples: half the error of
   choosing by area; from afar another fifth less, in 9/8 of the time. One in eight (8 u < 1) is by area alone. WHY: clusters
   are weighed roughly, at each level anew, and a triangle that ten levels thought little of counted 70,000 times. */
static uint32_t pktrt__light_find(const pktrt__light_data *light, bool moving, const double from[3], double *u,
                                  uint32_t to, double *inverse) {
  const pktrt__light_cluster *c = light->clusters;
  uint32_t first = 0, n = light->triangle_count;
  double times = 1, d2 = pktrt__distance2(from, c->middle), over[2], *way = u;
  const double back = d2 > c->r2 ? light->back : 1; /* within a globe all is seen */
  const double blind = moving ? 0 : 1.0 / 8, all = light->cdf[n - 1].sum, want = u ? 8 * *u * all : 0;
  if (u && *u < blind) way = NULL, to = pktrt__light_find_triangle(light, want);
  else if (u) *u = (*u - blind) / (1 - blind);
  while (!moving && n > 1 && (d2 < 4 * c->r2 || c->bent > 0.2)) {
    const pktrt__light_cluster *l = c + 1, *r = c + 2 * (n / 2);
    const double left2 = pktrt__distance2(from, l->middle), right2 = pktrt__distance2(from, r->middle);
    double left = pktrt__light_weigh_cluster(l, from, left2, back, &over[0]);
    double right = pktrt__light_weigh_cluster(r, from, right2, back, &over[1]);
    left *= over[1], right *= over[0];
    if (!(left + right > 0)) left = l->area > 0 ? 1 : 0, right = 1 - left;
    const double sum = left + right, t = way ? *way * sum : 0;
    const bool goes_left = way ? t < left || !(right > 0) : to < first + n / 2;
    const double each = 1 / pktrt__max(goes_left ? left : right, DBL_MIN);
    times *= sum * each;
    if (way) *way = (goes_left ? t : t - left) * each;
    if (goes_left) c = l, n = n / 2, d2 = left2;
    else c = r, first += n / 2, n -= n / 2, d2 = right2;
  }
  const double sum = light->cdf[first + n - 1].sum, before = first ? light->cdf[first - 1].sum : 0;
  const double here = !way ? want : before + *way * (sum - before);
  uint32_t i = way && n > 1 ? pktrt__light_find_triangle(light, here) : way ? first : to;
  i = i < first ? first : i < first + n ? i : first + n - 1;
  const double area = light->triangles[i].area, of = sum - before;
  *inverse = area > 0 ? 1 / (area * ((1 - blind) / (times * of) + blind / all)) : 0;
  if (u && (n > 1 || !way)) *u = area > 0 ? 1 - (light->cdf[i].sum - here) / area : 0;
  return i;
}

/* Returns a triangle of a light as it lies at a time, in *moved if it moves. */
static const pktrt__light_triangle *pktrt__light_triangle_at(const pktrt__mesh *m, const pktrt__light_triangle *f,
                                                             float time, pktrt__light_triangle *moved) {
  float p[3][3];
  if (!pktrt__has_motion(m->key_count)) return f;
  for (uint32_t c = 0; c < 3; c++) pktrt__mesh_corner_at(m, m->positions, f->triangle, c, time, p[c]);
  pktrt__light_place_triangle(p, moved);
  return moved;
}

/* Looks at a triangle from a point. Returns the solid angle, or 0: it is sampled by area. */
static double pktrt__light_look_at_triangle(const pktrt__light_triangle *f, const double from[3],
                                            pktrt__solid_angle *s) {
  double c[3][3], middle[3];
  for (int a = 0; a < 3; a++)
    c[0][a] = f->corner[a] - from[a], c[1][a] = c[0][a] + f->edge[0][a], c[2][a] = c[0][a] + f->edge[1][a];
  for (int a = 0; a < 3; a++) middle[a] = (c[0][a] + c[1][a] + c[2][a]) / 3;
  if (!(pktrt__dot(middle, middle) < pktrt__light_near2(f->edge[0], f->edge[1]))) return 0;
  return pktrt__solid_angle_of(c[1], c[0], c[2], pktrt__dot(c[0], f->normal), s);
}
/* Returns one over the density by area of a point `at`: with N the cross product of the edges, the light's cosine times the
   area is |N to| / (2 r). */
static double pktrt__light_triangle_spread(const pktrt__light_triangle *f, const double from[3], const double at[3]) {
  const double d[3] = {at[0] - from[0], at[1] - from[1], at[2] - from[2]}, r2 = pktrt__dot(d, d);
  return r2 > 0 ? 0.5 * fabs(pktrt__dot(d, f->normal)) / (r2 * sqrt(r2)) : 0;
}

/* Samples a point on the triangle that u[0] falls to, moved off the light farther than a ray that arrives can err: its
   direction is rounded, eps of the distance, and so is t. */
static double pktrt__light_sample_mesh(const pktrt__render_state *render, uint32_t index, const float u[2],
                                       const pktrt__light_view *from, double at[3]) {
  const pktrt__mesh *m = &render->scene->meshes[render->scene->lights[index].mesh];
  const pktrt__light_data *light = &render->lights[index];
  if (!(light->triangle_count && light->clusters->area > 0)) return 0;
  double x = (double)u[0], y = (double)u[1], inverse, size = 0, d[3];
  const bool moving = pktrt__has_motion(m->key_count);
  pktrt__light_triangle moved;
  pktrt__solid_angle s;
  const pktrt__light_triangle *f = pktrt__light_triangle_at(
      m, &light->triangles[pktrt__light_find(light, moving, from->point, &x, 0, &inverse)], from->time, &moved);
  for (int a = 0; a < 3; a++) d[a] = f->corner[a] - from->point[a];
  if (!(fabs(pktrt__dot(d, f->normal)) > pktrt__light_least_height(from->point) * f->length)) return 0;
  x = pktrt__min(pktrt__max(x, 0), 1);
  double spread = pktrt__light_look_at_triangle(f, from->point, &s);
  if (spread > 0) {
    pktrt__solid_angle_sample(&s, x, y, d);
    double along = 0;
    for (int a = 0; a < 3; a++) along += (f->corner[a] - from->point[a]) * f->normal[a];
    along /= pktrt__dot(d, f->normal);
    if (!(along > 0 && along <= FLT_MAX)) return 0;
    for (int a = 0; a < 3; a++) at[a] = from->point[a] + along * d[a];
  } else { /* the square, folded over the triangle: area is kept */
    const double root = sqrt(1 - x), v = root * y, w = root - v;
    for (int a = 0; a < 3; a++) at[a] = f->corner[a] + (w * f->edge[0][a] + v * f->edge[1][a]);
    spread = pktrt__light_triangle_spread(f, from->point, at);
  }
  for (int a = 0; a < 3; a++) d[a] = from->point[a] - at[a], size += fabs(at[a]);
  double offset = (4 * PKTRT__EPS * sqrt(pktrt__dot(d, d)) + 16 * PKTRT__ERROR_PLANE * size) / f->length;
  if (pktrt__dot(d, f->normal) < 0) offset = -offset;
  for (int a = 0; a < 3; a++) at[a] += offset * f->normal[a];
  return spread * inverse;
}

/* Returns one over the density with which a point of a mesh is sampled. */
static double pktrt__light_mesh_spread(const pktrt__render_state *render, uint32_t index, uint32_t triangle,
                                       const pktrt__light_view *from, const double at[3]) {
  const pktrt__mesh *m = &render->scene->meshes[render->scene->lights[index].mesh];
  const pktrt__light_data *light = &render->lights[index];
  const uint32_t place = light->places[triangle];
  double inverse;
  pktrt__light_triangle moved;
  pktrt__solid_angle s;
  (void)pktrt__light_find(light, pktrt__has_motion(m->key_count), from->point, NULL, place, &inverse);
  const pktrt__light_triangle *f = pktrt__light_triangle_at(m, &light->triangles[place], from->time, &moved);
  const double spread = pktrt__light_look_at_triangle(f, from->point, &s);
  return inverse * (spread > 0 ? spread : pktrt__light_triangle_spread(f, from->point, at));
}

/* >>glass: where it is, for shadow rays that something stopped ----------------------------------------------------- */

/* How deep boxes of glass are nested at most. WHY nested: window panes stand around a whole hall; of the rays that were
   traced again for the sake of one box around them all, one in seven meets the innermost ones. */
enum { PKTRT__GLASS_DEPTH = 7 };

static bool pktrt__material_is_glass(const pktrt_scene *s, const pktrt__mesh *m) {
  const pktrt_material *mat = pktrt__material_of(s, m->material);
  return mat->specular == PKTRT_SPECULAR_DIELECTRIC && !mat->shader;
}

static bool pktrt__material_is_cutout(const pktrt_scene *s, const pktrt__mesh *m) {
  return PKTRT__SURFACES && pktrt__material_of(s, m->material)->cutout;
}
/* Tells whether shadow rays may pass a mesh. */
static bool pktrt__glass_is_passed(const pktrt__render_state *render, const pktrt__mesh *m) {
  return (render->passes_glass && pktrt__material_is_glass(render->scene, m)) ||
         pktrt__material_is_cutout(render->scene, m);
}

static void pktrt__glass_widen(pktrt__glass_box *box, const float lo[3], const float hi[3]) {
  for (int a = 0; a < 3; a++) box->lo[a] = pktrt__minf(box->lo[a], lo[a]), box->hi[a] = pktrt__maxf(box->hi[a], hi[a]);
}

/* Tells whether rays of the camera may start in the box of a mesh of glass. */
static bool pktrt__glass_contains_camera(const pktrt_camera *c, const pktrt__glass_mesh *g) {
  bool apart = false;
  for (int a = 0; a < 3; a++) {
    const float end = c->moving ? c->eye_end[a] : c->eye[a], lens = 0.5f * c->aperture;
    apart |= pktrt__maxf(c->eye[a], end) + lens < g->lo[a] || pktrt__minf(c->eye[a], end) - lens > g->hi[a];
  }
  return !apart;
}

/* Turns a float's bits into a number that is ordered as floats are. */
static uint32_t pktrt__ordered_bits(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits >> 31 ? ~bits : bits | 0x80000000u;
}
static void pktrt__glass_empty_box(pktrt__glass_box *box) {
  for (int a = 0; a < 3; a++) box->lo[a] = INFINITY, box->hi[a] = -INFINITY;
}
static bool pktrt__glass_boxes_touch(const pktrt__glass_box *a, const pktrt__glass_box *b) {
  bool apart = false;
  for (int k = 0; k < 3; k++) apart |= a->hi[k] < b->lo[k] || b->hi[k] < a->lo[k];
  return !apart;
}

/* Widens a box by a triangle at all its keys. */
static void pktrt__glass_widen_by(const pktrt_scene *s, const pktrt__mesh *m, uint32_t triangle,
                                  pktrt__glass_box *box) {
  if (m->instance) { /* by all of it */
    const pktrt__mesh *all = &s->boxes->meshes[m->instance - 1];
    for (uint32_t key = 0; key < all->key_count; key++)
      pktrt__glass_widen(box, all->positions + 9 * (size_t)key, all->positions + 9 * (size_t)key + 3);
  }
  for (uint32_t key = 0; key < m->key_count; key++) {
    float p[3][3];
    pktrt__mesh_triangle(m, false, triangle, key, p);
    for (int c = 0; c < 3; c++) pktrt__glass_widen(box, p[c], p[c]);
  }
}

/* Returns how many parts of a mesh have boxes of their own: all of an instance has one. */
static uint32_t pktrt__glass_parts(const pktrt__mesh *m) {
  return m->instance && m->triangle_count ? 1 : m->triangle_count;
}

/* Makes boxes of meshes of glass or, if `fine`, of a few adjacent triangles that touch. Returns how many. */
static uint32_t pktrt__glass_make_boxes(const pktrt__render_state *render, bool fine, pktrt__glass_box *boxes) {
  const pktrt_scene *s = render->scene;
  uint32_t n = 0, held = 0; /* held: triangles in the last box */
  for (uint32_t i = 0; i < s->committed_meshes; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    for (uint32_t t = 0; t < pktrt__glass_parts(m) && pktrt__glass_is_passed(render, m); t++) {
      pktrt__glass_box box;
      pktrt__glass_empty_box(&box);
      pktrt__glass_widen_by(s, m, t, &box);
      if (t && (!fine || (held < 16 && pktrt__glass_boxes_touch(&boxes[n - 1], &box))))
        pktrt__glass_widen(&boxes[n - 1], box.lo, box.hi);
      else boxes[n++] = box, held = 0;
      held++;
    }
  }
  return n;
}

/* Nests n > 0 boxes in a tree of boxes, halving them along the longest axis. Returns how many boxes that makes. */
static uint32_t pktrt__glass_nest_boxes(pktrt__glass_box *in, uint32_t n, uint32_t depth, float slack,
                                        pktrt__glass_box *to) {
  uint32_t half = 0;
  int axis = 0;
  pktrt__glass_empty_box(to);
  for (uint32_t i = 0; i < n; i++) pktrt__glass_widen(to, in[i].lo, in[i].hi);
  for (int a = 1; a < 3; a++)
    if (to->hi[a] - to->lo[a] > to->hi[axis] - to->lo[axis]) axis = a;
  for (uint32_t i = 0; i < n; i++) {
    const pktrt__glass_box box = in[i];
    if (box.lo[axis] + box.hi[axis] < to->lo[axis] + to->hi[axis]) in[i] = in[half], in[half++] = box;
  }
  for (int a = 0; a < 3; a++) to->lo[a] -= slack, to->hi[a] += slack;
  to->next = 1;
  if (!half || half == n || depth == PKTRT__GLASS_DEPTH) return to->next;
  to->next += pktrt__glass_nest_boxes(in, half, depth + 1, slack, to + to->next);
  return to->next += pktrt__glass_nest_boxes(in + half, n - half, depth + 1, slack, to + to->next);
}

static void pktrt__glass_put_beside(pktrt__glass_mesh *g, uint32_t other) {
  if (g->beside_count < PKTRT__BESIDE) g->beside[g->beside_count] = other;
  g->beside_count++;
}
/* Finds out which of n meshes of glass have boxes that touch, by a sweep in the order in which the boxes begin. */
PKTRT__COLD void pktrt__glass_find_touching(pktrt__glass_mesh *g, uint64_t *order, uint32_t n) {
  pktrt__sort_keys(order, n);
  for (uint32_t i = 0; i < n; i++) {
    pktrt__glass_mesh *a = &g[(uint32_t)order[i]];
    for (uint32_t j = i + 1; j < n && g[(uint32_t)order[j]].lo[0] <= a->hi[0]; j++) {
      pktrt__glass_mesh *b = &g[(uint32_t)order[j]];
      if (a->hi[1] < b->lo[1] || b->hi[1] < a->lo[1] || a->hi[2] < b->lo[2] || b->hi[2] < a->lo[2]) continue;
      pktrt__glass_put_beside(a, (uint32_t)order[j]), pktrt__glass_put_beside(b, (uint32_t)order[i]);
    }
  }
}

/* Hashes a vertex by its positions at all keys, and below, an edge: with opposite signs for its two directions. */
static uint64_t pktrt__glass_vertex_hash(const pktrt__mesh *m, uint64_t vertex) {
  uint64_t number = 0;
  for (uint32_t key = 0; key < m->key_count; key++) {
    const float *p = m->positions + ((uint64_t)key * m->vertex_count + vertex) * 3;
    for (int a = 0; a < 3; a++) {
      const float x = p[a] + 0.0f; /* -0 is 0 */
      uint32_t bits;
      memcpy(&bits, &x, sizeof bits);
      number = (number + bits) * UINT64_C(0xD1342543DE82EF95);
    }
  }
  return number;
}
static uint64_t pktrt__glass_edge_hash(uint64_t a, uint64_t b) {
  return pktrt__hash(a + 3 * b) - pktrt__hash(b + 3 * a);
}

/* Tells whether each edge of a mesh, by position, has as many triangles in one direction as in the other: then what the
   mesh bounds has an inside. Hashes of edges sum up to 0 then, and else but by a chance of 2^-64. */
static bool pktrt__glass_is_closed(const pktrt__mesh *m) {
  uint64_t sum = 0;
  for (uint64_t i = 0; i < (uint64_t)m->triangle_count * 3; i += 3) {
    uint64_t v[3];
    for (uint32_t c = 0; c < 3; c++) v[c] = pktrt__glass_vertex_hash(m, m->indices ? m->indices[i + c] : i + c);
    sum += pktrt__glass_edge_hash(v[0], v[1]) + pktrt__glass_edge_hash(v[1], v[2]) + pktrt__glass_edge_hash(v[2], v[0]);
  }
  return sum == 0;
}

/* Finds the closed meshes of glass and their boxes, and whether the camera may stand in one. False: out of memory. */
static bool pktrt__glass_find_meshes(pktrt__render_state *render, float slack) {
  const pktrt_scene *s = render->scene;
  const uint32_t meshes = s->committed_meshes;
  uint32_t n = 0;
  pktrt__glass_mesh *g = PKTRT__CAST(pktrt__glass_mesh *, pktrt__mem_alloc(&s->desc, meshes, sizeof *g));
  uint64_t *order = PKTRT__CAST(uint64_t *, pktrt__mem_alloc(&s->desc, meshes, sizeof *order));
  render->glass_meshes = g;
  for (uint32_t i = 0; g && order && i < meshes; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    pktrt__glass_box box;
    pktrt__glass_empty_box(&box);
    g[i].closed =
        m->triangle_count && pktrt__material_is_glass(s, m) && pktrt__glass_is_closed(pktrt__mesh_source(s, i)),
    g[i].beside_count = 0;
    for (uint32_t t = 0; t < pktrt__glass_parts(m) && g[i].closed; t++) pktrt__glass_widen_by(s, m, t, &box);
    for (int a = 0; a < 3; a++) g[i].lo[a] = box.lo[a] - slack, g[i].hi[a] = box.hi[a] + slack;
    if (!g[i].closed) continue;
    order[n++] = (uint64_t)pktrt__ordered_bits(g[i].lo[0]) << 32 | i;
    render->starts_in_glass = render->starts_in_glass || pktrt__glass_contains_camera(&render->desc->camera, &g[i]);
  }
  if (order && g) pktrt__glass_find_touching(g, order, n);
  pktrt__mem_release(&s->desc, order, meshes, sizeof *order);
  return g && order;
}

/* Finds where glass is: in fine boxes only if samples are enough to pay for them. False: out of memory. */
PKTRT__COLD bool pktrt__glass_find(pktrt__render_state *render, uint64_t samples) {
  const pktrt_scene *s = render->scene;
  pktrt__glass_boxes *glass = &render->glass;
  uint64_t n = 0, meshes = 0;
  bool glassy = false;
  render->passes_glass =
      pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC) && render->desc->glass_shadows == PKTRT_GLASS_SHADOWS_PASS;
  for (uint32_t i = 0; i < s->committed_meshes; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    if (!m->triangle_count) continue;
    if (pktrt__glass_is_passed(render, m)) n += pktrt__glass_parts(m), meshes++;
    glassy = glassy || pktrt__material_is_glass(s, m), render->cutouts |= pktrt__material_is_cutout(s, m);
  }
  if (pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC) && glassy &&
      !pktrt__glass_find_meshes(render, 4e-6f * s->largest))
    return false;
  if (!n) return true;
  const bool fine = n / 4 < samples;
  n = fine ? n : meshes;
  glass->least = 1e-7f * pktrt__minf(1, s->largest);
  glass->room = n < (1u << PKTRT__GLASS_DEPTH) ? (uint32_t)n * 2 : 2u << PKTRT__GLASS_DEPTH;
  glass->boxes = PKTRT__CAST(pktrt__glass_box *, pktrt__mem_alloc(&s->desc, glass->room, sizeof *glass->boxes));
  pktrt__glass_box *in = PKTRT__CAST(pktrt__glass_box *, pktrt__mem_alloc(&s->desc, n, sizeof *in));
  if (in && glass->boxes)
    (void)pktrt__glass_nest_boxes(in, pktrt__glass_make_boxes(render, fine, in), 0, 4e-6f * s->largest, glass->boxes);
  pktrt__mem_release(&s->desc, in, n, sizeof *in);
  return in && glass->boxes;
}

/* Frees what pktrt__render_prepare makes once for a render. */
static void pktrt__render_unprepare(pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  pktrt__mem_release(&s->desc, render->glass.boxes, render->glass.room, sizeof *render->glass.boxes);
  pktrt__mem_release(&s->desc, render->glass_meshes, s->committed_meshes, sizeof *render->glass_meshes);
  pktrt__light_free_all(render);
}
static bool pktrt__render_prepare(pktrt__render_state *render,
                                  uint64_t pixels) { /* false: out of memory, and nothing is left */
  if (!pktrt__light_make_all(render)) return false;
  if (pktrt__glass_find(render, pixels * render->samples)) return true;
  pktrt__render_unprepare(render);
  return false;
}

/* >>media: which glasses a ray is in -------------------------------------------------------------------------------

   A ray carries a stack of the glasses it has entered and not left, the last one on top, which absorbs. An entry is
   twice the material, plus 1 if the mesh is open, and 8 bits wide, so that a number of 32 bits holds four; 16 where
   there are more than 127 materials, 32 beyond 32,767. What is pushed out at the bottom is forgotten.

   A closed mesh has an inside, wherever others are: it is pushed, and removed wherever in the stack it is. Open meshes
   are sheets, or share what they bound, as glass, water and what lies between them in a tumbler that is modelled by
   interfaces: a ray leaves one such body where it enters the next, so of adjacent entries one at most is open. If a ray
   meets a glass from the inside that its stack lacks, it came in through another mesh, or the glass was forgotten.

   Faces that coincide hide each other: where two glasses touch, a ray meets the face of one mesh, and starts behind
   both. So within the box of another closed mesh that touches its own, faces are searched for in the layer that the
   refracted ray skips. For this, and for the glasses around the camera, crossings are counted along a line, in plain C.
   Of glasses that are entered at once, or found around the camera, the one with the smaller box is the inner one. */

static uint32_t pktrt__media_entry(const pktrt_scene *s, const pktrt__glass_mesh *glass, uint32_t mesh) {
  return s->meshes[mesh].material << 1 | !glass[mesh].closed;
}
static uint32_t pktrt__media_entry_bits(const pktrt_scene *s) {
  return s->material_count < 128 ? 8 : s->material_count < 32768 ? 16 : 32;
}
static uint32_t pktrt__media_top(const pktrt_scene *s, uint32_t stack) {
  return stack & (UINT32_MAX >> (32 - pktrt__media_entry_bits(s)));
}
/* Splits a stack into its `at` lowest bits and those above. */
static uint32_t pktrt__media_bits_below(uint32_t stack, uint32_t at) {
  return (uint32_t)(stack & ((UINT64_C(1) << at) - 1));
}
static uint32_t pktrt__media_bits_above(uint32_t stack, uint32_t at) { return (uint32_t)((uint64_t)stack >> at); }

/* Returns how many bits of a stack lie below the topmost entry `medium`; 32 or more if there is none. */
static uint32_t pktrt__media_find(const pktrt_scene *s, uint32_t stack, uint32_t medium) {
  uint32_t at = 0;
  while (at < 32 && pktrt__media_top(s, pktrt__media_bits_above(stack, at)) != medium) at += pktrt__media_entry_bits(s);
  return at;
}
static uint32_t pktrt__media_enter(const pktrt_scene *s, uint32_t stack, uint32_t medium) {
  const uint32_t bits = pktrt__media_entry_bits(s);
  if (medium & stack & 1) stack = pktrt__media_bits_above(stack, bits);
  return (uint32_t)((uint64_t)stack << bits) | medium;
}
static uint32_t pktrt__media_leave(const pktrt_scene *s, uint32_t stack, uint32_t medium) {
  uint32_t at = pktrt__media_find(s, stack, medium);
  if (at >= 32 && (medium & stack & 1)) at = 0;
  if (at >= 32) return stack;
  return pktrt__media_bits_above(stack, at + pktrt__media_entry_bits(s)) << at | pktrt__media_bits_below(stack, at);
}
/* Adds a glass that a ray met from the inside to its stack, unless it is there: the ray must have been in it. */
static uint32_t pktrt__media_know(const pktrt_scene *s, uint32_t stack, uint32_t medium) {
  return pktrt__media_find(s, stack, medium) < 32 ? stack : pktrt__media_enter(s, stack, medium);
}

/* Returns the transmittance, in one channel, of a distance through the glass on top of a stack. */
static float pktrt__media_transmittance(const pktrt_scene *s, uint32_t stack, int a, double distance) {
  const uint32_t material = pktrt__media_top(s, stack) >> 1;
  const float absorption = material ? pktrt__material_of(s, material)->absorption[a] : 0;
  return absorption > 0 ? (float)pktrt__math_exp(-(double)absorption * distance) : 1;
}

enum { PKTRT__CROSSED = 8 }; /* crossings are counted for so many meshes at most; others are overlooked */
/* Crossings of a line with closed meshes of glass whose boxes contain its origin. */
typedef struct pktrt__media_crossings {
  const pktrt_scene *scene;
  const pktrt__glass_mesh *glass;
  const float *origin;
  uint32_t skip; /* a mesh whose crossings are not counted */
  uint32_t mesh[PKTRT__CROSSED], count;
  int exits[PKTRT__CROSSED]; /* minus entries */
} pktrt__media_crossings;

static bool pktrt__glass_contains(const pktrt__glass_mesh *g, const float p[3]) {
  for (int a = 0; a < 3; a++)
    if (!(g->lo[a] <= p[a] && p[a] <= g->hi[a])) return false;
  return true;
}
/* Tells whether a point at a mesh of glass may be in another: whether the box of one that touches it contains it. */
static bool pktrt__glass_is_beside(const pktrt__glass_mesh *glass, uint32_t mesh, const float p[3]) {
  const pktrt__glass_mesh *g = &glass[mesh];
  bool any = g->beside_count > PKTRT__BESIDE;
  for (uint32_t i = 0; i < g->beside_count && !any; i++) any = pktrt__glass_contains(&glass[g->beside[i]], p);
  return any;
}

static void pktrt__media_count_crossing(void *of, uint32_t mesh, int exits) {
  pktrt__media_crossings *c = PKTRT__CAST(pktrt__media_crossings *, of);
  const pktrt__glass_mesh *g = &c->glass[mesh];
  uint32_t i = 0;
  if (mesh == c->skip || !g->closed) return;
  if (!pktrt__glass_contains(g, c->origin)) return;
  while (i < c->count && c->mesh[i] != mesh) i++;
  if (i == PKTRT__CROSSED) return;
  if (i == c->count) c->mesh[i] = mesh, c->exits[i] = 0, c->count++;
  c->exits[i] += exits;
}

/* Counts crossings between o and o + tmax d. */
static void pktrt__media_count_crossings(pktrt__media_crossings *c, const float o[3], const float d[3], float tmax,
                                         float time) {
  pktrt_ray ray = pktrt_make_ray(o, d);
  ray.tmax = tmax, ray.time = time;
  c->count = 0, c->origin = ray.origin;
  pktrt__crossing_each(c->scene, &ray, pktrt__media_count_crossing, c);
}

static float pktrt__glass_extent(const pktrt__glass_mesh *g) {
  return (g->hi[0] - g->lo[0]) + (g->hi[1] - g->lo[1]) + (g->hi[2] - g->lo[2]);
}

/* Enters n meshes of glass at once, the largest first; changes their order. */
static uint32_t pktrt__media_enter_meshes(const pktrt_scene *s, const pktrt__glass_mesh *glass, uint32_t stack,
                                          uint32_t *mesh, uint32_t n) {
  for (; n; n--) {
    uint32_t largest = 0;
    for (uint32_t i = 1; i < n; i++) {
      const float size = pktrt__glass_extent(&glass[mesh[i]]), most = pktrt__glass_extent(&glass[mesh[largest]]);
      if (size > most || (size == most && mesh[i] < mesh[largest])) largest = i;
    }
    stack = pktrt__media_enter(s, stack, pktrt__media_entry(s, glass, mesh[largest]));
    mesh[largest] = mesh[n - 1];
  }
  return stack;
}

/* Returns the glasses around a point at a time: those that a line from it leaves more often than it enters them. */
static uint32_t pktrt__media_around(const pktrt_scene *s, const pktrt__glass_mesh *glass, const float point[3],
                                    float time) {
  static const float ahead[3] = {0.259f, 0.933f, 0.2495f}; /* along no axis, where edges would be met exactly */
  uint32_t mesh[PKTRT__CROSSED], n = 0;
  pktrt__media_crossings c;
  c.scene = s, c.glass = glass, c.skip = PKTRT_NONE;
  pktrt__media_count_crossings(&c, point, ahead, INFINITY, time);
  for (uint32_t i = 0; i < c.count; i++)
    if (c.exits[i] > 0) mesh[n++] = c.mesh[i];
  return pktrt__media_enter_meshes(s, glass, 0, mesh, n);
}

/* Returns the stack of a ray that leaves or enters `mesh`, of glass, and goes on at `behind`; `before` is this side. */
static uint32_t pktrt__media_pass_surface(const pktrt_scene *s, const pktrt__glass_mesh *glass, uint32_t stack,
                                          uint32_t mesh, bool leaves, const float before[3], const float behind[3],
                                          float time) {
  uint32_t entered[PKTRT__CROSSED + 1], n = 0;
  pktrt__media_crossings c;
  c.count = 0;
  if (pktrt__glass_is_beside(glass, mesh, before)) {
    const float d[3] = {behind[0] - before[0], behind[1] - before[1], behind[2] - before[2]};
    c.scene = s, c.glass = glass, c.skip = mesh;
    pktrt__media_count_crossings(&c, before, d, 1, time);
  }
  if (leaves) stack = pktrt__media_leave(s, stack, pktrt__media_entry(s, glass, mesh));
  else entered[n++] = mesh;
  for (uint32_t i = 0; i < c.count; i++) {
    if (c.exits[i] > 0) stack = pktrt__media_leave(s, stack, pktrt__media_entry(s, glass, c.mesh[i]));
    if (c.exits[i] < 0) entered[n++] = c.mesh[i];
  }
  return pktrt__media_enter_meshes(s, glass, stack, entered, n);
}

/* >>workspace ------------------------------------------------------------------------------------------------------ */

/* Fills n values of a row and up to seven behind them, for compilers vectorise loops of known length. */
PKTRT__NOINLINE void pktrt__fill_row(float *row, uint32_t n, float x) {
  for (uint32_t i = 0; i < n; i += 8)
    for (uint32_t j = 0; j < 8; j++) row[i + j] = x;
}

/* Pending rays of a packet, and where their hits or their light go. */
typedef struct pktrt__packet_queue {
  pktrt__batch batch;
  float contribution[3][PKTRT__ROW]; /* shadow rays: the light that the surface gets if nothing stops it, */
  float through[3][PKTRT__ROW];      /* and what of it passes glass, where that is less (tile->apart) */
  float visible[3][PKTRT__ROW];      /* shadow rays: the part of it that arrives */
  uint32_t target[PKTRT__ROW];       /* surface, or lane of a wave */
  pktrt__wave *wave[PKTRT__BATCH];   /* NULL: a shadow ray */
  uint32_t n;
} pktrt__packet_queue;

/* The working space of one tile. */
typedef struct pktrt__tile {
  pktrt__packet_queue queue;
  pktrt__batch glass_batch; /* shadow rays on their way through glass */
  pktrt__wave primary;
  pktrt__surfaces surfaces;
  pktrt__light_samples light_samples;
  pktrt__sample_batch draws;
  pktrt__shadow_rays shadow_rays;
  pktrt__shadow_list shadow_list;
  const pktrt__render_state *render;
  pktrt_sampling sampling; /* of this pass */
  uint32_t pass;           /* passes that the pixels had before */
  pktrt_stats *stats;
  pktrt__wave *reflected[PKTRT_MAX_DEPTH + 1], *refracted[PKTRT_MAX_DEPTH + 1], *spare; /* by depth */
  uint32_t order[PKTRT__BATCH], packet[PKTRT__BATCH], sender[PKTRT__BATCH];             /* see pktrt__packet_assemble */
  pktrt__light_cut *cuts;        /* NULL where all lights are asked */
  uint32_t chosen[PKTRT__BATCH]; /* the light that each surface samples, if it samples only one, */
  double share[PKTRT__BATCH];    /* and one over the probability of this choice */
  uint32_t first;                /* in the wave being shaded: the first ray of `surfaces` */
  const pktrt__wave *shaded;     /* that wave */
  bool apart;                    /* see pktrt__shadow_rays: `through` is wanted */
  bool in_glass;                 /* some of these surfaces lie in glass */
  bool one_by_one;               /* no packets: every ray by itself */
  bool large_waves;              /* waves of many packets: reflected and refracted rays share one if they fit */
  uint32_t x[PKTRT__BATCH], y[PKTRT__BATCH], sample[PKTRT__BATCH]; /* of the primary rays */
  uint32_t pixel[PKTRT__BATCH];                     /* of the primary rays: index of a pixel of the block */
  uint8_t across[PKTRT__BATCH], down[PKTRT__BATCH]; /* places of a cell's pixels in the cell */
  uint8_t deepest[PKTRT__BATCH];
  bool split[PKTRT__BATCH];                           /* pixels of the block where both rays are followed */
  bool refracts[PKTRT__BATCH];                        /* of the rays from there, */
  float fresnel[PKTRT__BATCH], fork[3][PKTRT__BATCH]; /* of the primary rays: see pktrt__split_end */
  double sum[3][PKTRT__BATCH];                        /* of the pixels of the block */
  float gain[PKTRT__BATCH], splits[PKTRT__BATCH];     /* see pktrt__pixel_sums */
  double depth[PKTRT__BATCH], normal[3][PKTRT__BATCH], albedo[3][PKTRT__BATCH], cost[PKTRT__BATCH];
  uint32_t hit_count[PKTRT__BATCH];
  bool failed; /* out of memory, or stopped: nothing more is traced or written */
  bool stopped;
  struct pktrt__pass_rounds *rounds; /* may stop it, if not NULL */
  uint32_t shaded_packets;
} pktrt__tile;

static bool pktrt__pass_goes_on(struct pktrt__pass_rounds *rounds);

/* Asks every 256 packets, some milliseconds, whether the render goes on. WHY within tiles: where glass branches and
   nothing is attenuated, the rays of one pixel may take hours. */
static bool pktrt__tile_is_stopped(pktrt__tile *tile) {
  if (tile->rounds && ++tile->shaded_packets % 256 == 0 && !pktrt__pass_goes_on(tile->rounds))
    tile->failed = tile->stopped = true;
  return tile->failed;
}

static void pktrt__sample_batch_end(pktrt__sample_batch *g, uint32_t n) {
  for (g->count = n; n % PKTRT__DRAWN; n++) g->x[n] = g->y[n] = g->sample[n] = g->group[n] = 0;
}

/* Draws as pktrt__tile_draw does from the caller's function; what is not in [0,1) is moved there, NaN to 0. */
PKTRT__COLD void pktrt__tile_draw_custom(pktrt__tile *tile, uint32_t k, uint32_t dimension, uint32_t n) {
  pktrt__sample_batch *g = &tile->draws;
  const pktrt_render_desc *d = tile->render->desc;
  for (uint32_t i = k; i < k + PKTRT__DRAWN && i < g->count; i++)
    for (uint32_t a = dimension; a < dimension + n; a++) {
      const float u =
          d->custom_sampler(d->user, g->x[i], g->y[i], g->sample[i], 4 * g->group[i] + a, tile->sampling.seed);
      g->u[a % 4][i] = !(u > 0) ? 0 : pktrt__minf(u, 1 - FLT_EPSILON / 2);
    }
}

/* Draws n dimensions, from a given one on and all of one group, of PKTRT__DRAWN samples from k on. */
static void pktrt__tile_draw(pktrt__tile *tile, uint32_t k, uint32_t dimension, uint32_t n) {
  pktrt__sample_batch *g = &tile->draws;
  const pktrt_sampling *s = &tile->sampling;
  const uint32_t first = dimension % 4;
  if (s->sampler == PKTRT_SAMPLER_CUSTOM) {
    pktrt__tile_draw_custom(tile, k, dimension, n);
    return;
  }
  if (pktrt__sampler_rows[s->sampler].drawn != PKTRT__DRAWN_SINGLY) {
    tile->render->scene->kernels->draw_samples(s, g, k, dimension / 4, first, n);
    return;
  }
  for (uint32_t i = k; i < k + PKTRT__DRAWN && i < g->count; i++) {
    float u[4];
    pktrt__sampler_sample(s, g->x[i], g->y[i], g->sample[i], 4 * g->group[i] + dimension, n, u);
    for (uint32_t a = 0; a < n; a++) g->u[first + a][i] = u[a];
  }
}

PKTRT__NOINLINE void pktrt__tile_draw_all(pktrt__tile *tile, uint32_t dimension, uint32_t n) {
  for (uint32_t k = 0; k < tile->draws.count; k += PKTRT__DRAWN) pktrt__tile_draw(tile, k, dimension, n);
}

/* >>surfaces: what the rays of a wave found ------------------------------------------------------------------------ */

/* Finds mesh, triangle and material of each surface. Prefetches smooth normals: otherwise two waits for
   memory per triangle would follow each other. */
static void pktrt__surface_identify(const pktrt_scene *scene, bool smooth, const pktrt__wave *w, pktrt__surfaces *s) {
  uint32_t hint[2] = {0, 0}, mesh = 0, first = 0, n = 0;
  const pktrt__mesh *m = NULL;
  bool bent = false;
  for (uint32_t k = 0; k < s->count; k++) {
    const uint32_t id = w->rays.id[s->first + k];
    if (id - first >= n) {
      mesh = pktrt__mesh_lookup(scene, id, w->rays.place + s->first + k, hint), m = &scene->meshes[mesh];
      first = m->first_id, n = m->triangle_count;
      bent = smooth && m->normals && m->indices; /* of an instance, no: it has no arrays */
    }
    s->mesh[k] = mesh, s->triangle[k] = id - first, s->material[k] = m->material;
    if (bent) PKTRT__PREFETCH(m->indices + (size_t)(id - first) * 3);
  }
  for (uint32_t k = 0; smooth && k < s->count; k++) {
    if (k && s->triangle[k] == s->triangle[k - 1]) continue;
    m = &scene->meshes[s->mesh[k]];
    if (!m->normals || !m->indices || pktrt__has_motion(m->key_count)) continue;
    for (uint32_t c = 0; c < 3; c++)
      PKTRT__PREFETCH(m->normals + (size_t)m->indices[(size_t)s->triangle[k] * 3 + c] * 3);
  }
}

/* Finds the point of surface i, which belongs to an instance, and how far rays start from it. */
static void pktrt__surface_place(const pktrt_scene *scene, const pktrt__wave *w, pktrt__surfaces *s, uint32_t i) {
  const pktrt__batch *b = &w->rays;
  const uint32_t r = s->first + i;
  pktrt_ray ray;
  pktrt_hit hit;
  pktrt__spawn_point x;
  for (int a = 0; a < 3; a++) {
    ray.origin[a] = b->o[a][r], ray.direction[a] = b->d[a][r];
    hit.normal[a] = b->as.hit.normal[a][r];
  }
  ray.tmin = 0, ray.tmax = INFINITY, ray.time = b->time[r];
  hit.t = b->t[r], hit.u = b->as.hit.u[r], hit.v = b->as.hit.v[r], hit.mesh = s->mesh[i], hit.triangle = s->triangle[i];
  (void)pktrt__spawn_from(scene, &ray, &hit, NULL, &x);
  for (int a = 0; a < 3; a++) s->point[a][i] = x.at[a], s->position[a][i] = (float)x.at[a];
  const float more = pktrt__minf(24 * PKTRT__EPS * scene->largest, 5.7220458984375e-6f * s->distance[i]);
  s->offset[i] = pktrt__maxf((float)x.offset, more);
}
/* Gets the radiance of the environment in n directions. */
static void pktrt__environment_radiance(const pktrt__render_state *render, uint32_t n, float (*d)[64],
                                        float (*radiance)[64]) {
  const pktrt_render_desc *desc = render->desc;
  for (int a = 0; a < 3; a++)
    for (uint32_t i = 0; i < n; i++) radiance[a][i] = desc->background[a];
  if (!desc->environment) return;
  const float *const from[3] = {d[0], d[1], d[2]};
  float *const to[3] = {radiance[0], radiance[1], radiance[2]};
  desc->environment(desc->user, n, from, to);
}

/* Gives rays that met nothing the radiance of where they go; those that end at a light that is seen have theirs. */
static void pktrt__surface_shade_misses(const pktrt__render_state *render, pktrt__wave *w, uint32_t first, uint32_t n) {
  const bool shared = render->sky_light != PKTRT_NONE, shown = render->shown;
  float d[3][64], radiance[3][64];
  uint32_t lane[64], m = 0;
  for (uint32_t i = first; i < first + n; i++) {
    if (w->rays.slot[i] == PKTRT_NONE && !(shown && w->rays.t[i] < 0)) {
      double v[3] = {(double)w->rays.d[0][i], (double)w->rays.d[1][i], (double)w->rays.d[2][i]};
      for (int a = 0; a < 3; a++) w->radiance[a][i] = render->desc->background[a] * (shared ? w->sky[i] : 1);
      if (render->desc->environment && pktrt__normalise(v)) { /* false where a moving camera stands in its target */
        for (int a = 0; a < 3; a++) d[a][m] = (float)v[a];
        lane[m++] = i;
      }
    }
    if (m < 64 && (!m || i + 1 < first + n)) continue;
    pktrt__environment_radiance(render, m, d, radiance);
    for (uint32_t k = 0; k < m; k++)
      for (int a = 0; a < 3; a++) w->radiance[a][lane[k]] = radiance[a][k] * (shared ? w->sky[lane[k]] : 1);
    m = 0;
  }
}

/* Ends rays at visible lights that lie before what they hit. Rays of lobes bring nothing from there: direct light has. */
PKTRT__COLD void pktrt__surface_show_lights(const pktrt__render_state *render, pktrt__wave *w, uint32_t first,
                                            uint32_t n, uint32_t depth) {
  const pktrt_scene *scene = render->scene;
  pktrt__batch *b = &w->rays;
  for (uint32_t i = first; i < first + n; i++) {
    const double from[3] = {(double)b->o[0][i], (double)b->o[1][i], (double)b->o[2][i]};
    double d[3] = {(double)b->d[0][i], (double)b->d[1][i], (double)b->d[2][i]}, depth_of = INFINITY;
    if (b->slot[i] != PKTRT_NONE) depth_of = (double)b->t[i] * sqrt(pktrt__dot(d, d));
    else b->t[i] = INFINITY;
    if (!pktrt__normalise(d)) continue;
    const uint32_t light = pktrt__light_see(render, from, d, &depth_of);
    if (light == PKTRT_NONE) continue;
    const bool lobe = depth > 0 && pktrt__material_has_lobe(pktrt__material_of(scene, w->material[i]));
    const pktrt__light_data *l = &render->lights[light];
    for (int a = 0; a < 3; a++) {
      const double kept = (double)pktrt__media_transmittance(scene, w->medium[i], a, depth_of);
      w->radiance[a][i] = lobe ? 0 : pktrt__to_float(l->strength * (double)l->color[a] * kept);
    }
    b->slot[i] = PKTRT_NONE, b->t[i] = -1; /* but no miss */
  }
}

/* Fills tile->surfaces from the rays [first, first + n) of a wave that hit, whose values move to the front; the others
   get the environment's radiance. Not inlined, nor are pktrt__tile_evaluate_materials, pktrt__packet_flush and
   pktrt__light_add_direct: their arrays must not lie in every frame of the recursion. */
PKTRT__NOINLINE void pktrt__surface_gather(pktrt__tile *tile, pktrt__wave *w, uint32_t first, uint32_t n,
                                           uint32_t depth) {
  const pktrt_scene *scene = tile->render->scene;
  const bool smooth = pktrt__render_uses(tile->render, PKTRT_FEATURE_NORMALS);
  pktrt__surfaces *s = &tile->surfaces;
  bool missed = false;
  if (tile->render->shown) pktrt__surface_show_lights(tile->render, w, first, n, depth);
  for (uint32_t i = first; i < first + n; i++) missed |= w->rays.slot[i] == PKTRT_NONE;
  if (missed) pktrt__surface_shade_misses(tile->render, w, first, n);
  scene->kernels->pack_surfaces(w, first, n, s);
  pktrt__surface_identify(scene, smooth, w, s);
  scene->kernels->find_surfaces(scene, smooth, w, s);
}

/* >>materials ------------------------------------------------------------------------------------------------------ */

PKTRT__INLINE bool pktrt__bit_of(const uint8_t *bits, uint32_t k) { return bits[k / 8] >> k % 8 & 1; }

/* Calls the hooks of one material on surfaces [k, k + n), n <= 64, in place. */
static void pktrt__material_call_hooks(const pktrt_scene *scene, const pktrt__wave *w, pktrt__surfaces *s, uint32_t k,
                                       uint32_t n) {
  const pktrt_material *mat = pktrt__material_of(scene, s->material[k]);
  const uint32_t lane = s->first + k;
  float to[3][64], texcoord[2][64], opacity[64], *radiance[3];
  pktrt_points p;
  p.n = n, p.texcoord[0] = texcoord[0], p.texcoord[1] = texcoord[1], p.opacity = opacity;
  for (uint32_t i = 0; i < n; i++) {
    float at[2];
    pktrt__texcoord_at(scene, s->mesh[k + i], s->triangle[k + i], w->rays.as.hit.u[lane + i],
                       w->rays.as.hit.v[lane + i], at);
    texcoord[0][i] = at[0], texcoord[1][i] = at[1], opacity[i] = 1;
  }
  for (int a = 0; a < 3; a++) {
    p.position[a] = s->position[a] + k, p.direction[a] = s->d[a] + k, p.normal[a] = s->ns[a] + k;
    p.albedo[a] = s->albedo[a] + k, p.reflectance[a] = s->reflectance[a] + k, p.emission[a] = s->emission[a] + k;
    radiance[a] = to[a];
  }
  p.barycentric[0] = w->rays.as.hit.u + lane, p.barycentric[1] = w->rays.as.hit.v + lane;
  p.time = w->rays.time + lane;
  p.mesh = s->mesh + k, p.triangle = s->triangle + k;
  if (mat->texture) mat->texture(mat->user, &p);
  if (!mat->shader) return;
  memset(to, 0, sizeof to);
  mat->shader(mat->user, &p, radiance);
  for (int a = 0; a < 3; a++) memcpy(p.emission[a], to[a], n * sizeof(float));
}

/* Runs textures and shaders of the surfaces that have them, for all neighbours of one material at once. */
static void pktrt__material_run_hooks(const pktrt_scene *scene, const pktrt__wave *w, pktrt__surfaces *s) {
  for (uint32_t k = 0, end; k < s->count; k = end) {
    end = k + 1;
    if (!pktrt__bit_of(s->hooked, k)) continue;
    while (end < s->count && end < k + 64 && s->material[end] == s->material[k]) end++;
    pktrt__material_call_hooks(scene, w, s, k, end - k);
  }
}

/* Returns the media that a ray was in when it met surface k. */
static uint32_t pktrt__media_before(const pktrt_scene *scene, const pktrt__glass_mesh *glass, const pktrt__wave *w,
                                    const pktrt__surfaces *s, uint32_t k) {
  const uint32_t known = w->medium[s->first + k];
  const bool inside = pktrt__bit_of(s->kind[PKTRT_SPECULAR_DIELECTRIC], k) && pktrt__bit_of(s->inside, k);
  return inside ? pktrt__media_know(scene, known, pktrt__media_entry(scene, glass, s->mesh[k])) : known;
}

/* Attenuates surface k by what absorbs on the way to it (Beer). */
static void pktrt__surface_absorb(const pktrt_scene *scene, const pktrt__glass_mesh *glass, const pktrt__wave *w,
                                  pktrt__surfaces *s, uint32_t k) {
  const uint32_t media = pktrt__media_before(scene, glass, w, s, k);
  for (int a = 0; a < 3; a++) {
    const float kept = pktrt__media_transmittance(scene, media, a, (double)s->distance[k]);
    s->albedo[a][k] *= kept, s->emission[a][k] *= kept, s->reflected[a][k] *= kept, s->transmitted[a][k] *= kept;
  }
}
static void pktrt__material_weights_conductor(const pktrt_scene *scene, pktrt__surfaces *s, uint32_t k) {
  const pktrt_material *mat = pktrt__material_of(scene, s->material[k]);
  float cosine = 0;
  for (int a = 0; a < 3; a++) cosine -= s->d[a][k] * s->nf[a][k];
  for (int a = 0; a < 3; a++)
    s->reflected[a][k] =
        pktrt_fresnel_conductor(cosine, pktrt__material_ior(mat, a), mat->extinction[a]) * s->reflectance[a][k];
}

/* Adds to the weights of surfaces i to i + 7 what is not done by eights: metals' Fresnel terms and absorption. */
static void pktrt__material_weights_rest(const pktrt_scene *scene, const pktrt__glass_mesh *meshes,
                                         const pktrt__wave *w, pktrt__surfaces *s, uint32_t i, uint32_t metal,
                                         uint32_t glass) {
  for (; metal; metal &= metal - 1) pktrt__material_weights_conductor(scene, s, i + pktrt__lowest_bit(metal));
  for (; glass; glass &= glass - 1) pktrt__surface_absorb(scene, meshes, w, s, i + pktrt__lowest_bit(glass));
}

static bool pktrt__aov_wanted(const pktrt__render_state *render) {
  return render->desc->depth || render->desc->normal || render->desc->albedo;
}

/* Adds what primary rays met to the sums of the optional buffers (AOVs). */
static void pktrt__aov_add_first_hits(pktrt__tile *tile) {
  const pktrt__surfaces *s = &tile->surfaces;
  for (uint32_t k = 0; k < s->count; k++) {
    const uint32_t p = tile->pixel[s->ray[k]];
    const bool clear = tile->render->follow && pktrt__bit_of(s->bare, k);
    tile->hit_count[p]++;
    tile->depth[p] += (double)s->distance[k];
    for (int a = 0; a < 3; a++) {
      tile->normal[a][p] += (double)s->ns[a][k];
      tile->albedo[a][p] += clear ? 0 : (double)s->albedo[a][k];
    }
  }
}

/* Leaves of emission that rays of lobes found the part that samples of the light do not count. */
PKTRT__COLD void pktrt__surface_share_emission(const pktrt__tile *tile, const pktrt__wave *w, pktrt__surfaces *s) {
  const pktrt__render_state *render = tile->render;
  for (uint32_t k = 0; k < s->count; k++) {
    const double density = (double)w->density[s->ray[k]];
    const uint32_t light = density > 0 ? render->light_of_mesh[s->mesh[k]] : PKTRT_NONE, r = s->first + k;
    pktrt__light_view from;
    double at[3];
    if (light == PKTRT_NONE) continue;
    for (int a = 0; a < 3; a++) from.point[a] = (double)w->rays.o[a][r], at[a] = s->point[a][k];
    from.time = w->rays.time[r];
    const double inverse = pktrt__light_mesh_spread(render, light, s->triangle[k], &from, at) * density;
    for (int a = 0; a < 3; a++) s->emission[a][k] *= (float)(inverse / (1 + inverse));
  }
}

/* Evaluates the materials of all surfaces, and the radiance that needs no ray: emission and ambient light. */
PKTRT__NOINLINE void pktrt__tile_evaluate_materials(pktrt__tile *tile, const pktrt__wave *w, uint32_t depth) {
  pktrt__surfaces *s = &tile->surfaces;
  const pktrt__render_state *render = tile->render;
  const pktrt_render_desc *d = render->desc;
  bool hooks = false;
  for (uint32_t k = 0; pktrt__render_uses(render, PKTRT_FEATURE_TEXTURES) && k < s->count; k += 8)
    hooks |= s->hooked[k / 8] != 0;
  if (hooks) pktrt__material_run_hooks(render->scene, w, s);
  if (!depth && pktrt__aov_wanted(render)) pktrt__aov_add_first_hits(tile);
  if (depth && render->light_of_mesh) pktrt__surface_share_emission(tile, w, s);
  render->scene->kernels->evaluate_materials(render->scene, render->glass_meshes, render->follow, d->ambient, w, s);
}

static void pktrt__stats_add_words(void *to, const void *from, size_t size) { /* nothing but uint64_t in there */
  uint64_t a, b;
  for (size_t at = 0; at < size; at += sizeof a) {
    memcpy(&a, PKTRT__CAST(char *, to) + at, sizeof a);
    memcpy(&b, PKTRT__CAST(const char *, from) + at, sizeof b);
    a += b;
    memcpy(PKTRT__CAST(char *, to) + at, &a, sizeof a);
  }
}
static void pktrt__stats_add_counts(pktrt_counts *to, const pktrt_counts *from) {
  pktrt__stats_add_words(to, from, sizeof *to);
}
static void pktrt__stats_add(pktrt_stats *to, const pktrt_stats *from) { pktrt__stats_add_words(to, from, sizeof *to); }

/* >>assembly: how rays are put together to packets ---------------------------------------------------------------- */

/* Tells whether a hit of a cutout is at a transparent point. */
static bool pktrt__cutout_is_clear(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit) {
#ifdef PKTRT_NO_SURFACES
  (void)s, (void)ray, (void)hit;
  return false;
#else
  pktrt_surface_info x;
  double d[3] = {(double)ray->direction[0], (double)ray->direction[1], (double)ray->direction[2]};
  float unit[3], value[3][3], opacity = 1;
  const pktrt_material *mat = pktrt__material_of(s, s->meshes[hit->mesh].material);
  pktrt_points p;
  (void)pktrt__normalise(d);
  pktrt_surface(s, ray, hit, &x);
  p.n = 1, p.time = &ray->time, p.mesh = &hit->mesh, p.triangle = &hit->triangle, p.opacity = &opacity;
  for (int a = 0; a < 3; a++) {
    unit[a] = (float)d[a], value[0][a] = mat->albedo[a], value[1][a] = mat->reflectance[a];
    value[2][a] = mat->emission[a];
    p.position[a] = &x.position[a], p.direction[a] = &unit[a], p.normal[a] = &x.shading_normal[a];
    p.albedo[a] = &value[0][a], p.reflectance[a] = &value[1][a], p.emission[a] = &value[2][a];
  }
  p.barycentric[0] = &hit->u, p.barycentric[1] = &hit->v;
  p.texcoord[0] = &x.texcoord[0], p.texcoord[1] = &x.texcoord[1];
  mat->texture(mat->user, &p);
  return opacity < 0.5f;
#endif
}
/* Lets rays of a batch that hit transparent points of cutouts go on. */
PKTRT__NOINLINE void pktrt__cutout_pass(const pktrt_scene *s, pktrt__batch *b, uint32_t n) {
  uint32_t hint[2] = {0, 0};
  for (uint32_t i = 0; i < n; i++) {
    pktrt_ray ray;
    pktrt_hit hit;
    uint32_t where[3] = {b->slot[i], b->bvh[i], b->place[i]};
    if (where[0] == PKTRT_NONE) continue;
    pktrt__mesh_name_triangle(s, b->id[i], b->place + i, hint, &hit.mesh, &hit.triangle);
    if (!pktrt__material_is_cutout(s, &s->meshes[hit.mesh])) continue;
    for (int a = 0; a < 3; a++) {
      ray.origin[a] = b->o[a][i], ray.direction[a] = b->d[a][i];
      hit.normal[a] = b->as.hit.normal[a][i];
    }
    ray.tmin = b->tmin[i], ray.tmax = b->tmax[i], ray.time = b->time[i];
    hit.t = b->t[i], hit.u = b->as.hit.u[i], hit.v = b->as.hit.v[i];
    while (where[0] != PKTRT_NONE && pktrt__material_is_cutout(s, &s->meshes[hit.mesh]) &&
           pktrt__cutout_is_clear(s, &ray, &hit))
      if (!pktrt__crossing_next(s, &ray, &hit, &hit, where)) where[0] = PKTRT_NONE;
    for (int a = 0; a < 3; a++) b->as.hit.normal[a][i] = hit.normal[a];
    b->t[i] = hit.t, b->as.hit.u[i] = hit.u, b->as.hit.v[i] = hit.v;
    b->slot[i] = where[0], b->bvh[i] = where[1], b->place[i] = where[2];
    b->id[i] = where[0] == PKTRT_NONE ? PKTRT_NONE : s->meshes[hit.mesh].first_id + hit.triangle;
  }
}

/* Returns the primary ray that pending ray k descends from. */
static uint32_t pktrt__packet_root(const pktrt__tile *tile, uint32_t k) {
  const pktrt__packet_queue *p = &tile->queue;
  return p->wave[k] ? p->wave[k]->root[p->target[k]] : tile->shaded->root[tile->surfaces.first + p->target[k]];
}

/* Tells whether some of n rays add to pixels whose events are wanted. Those are pending rays `lane`; NULL: the first n. */
PKTRT__COLD bool pktrt__packet_is_traced(const pktrt__tile *tile, const uint32_t *lane, uint32_t n) {
  const uint32_t *area = tile->render->desc->trace_area;
  bool any = !(area[0] | area[1] | area[2] | area[3]);
  for (uint32_t i = 0; i < n && !any; i++) {
    const uint32_t root = pktrt__packet_root(tile, lane ? lane[i] : i);
    any = tile->x[root] - area[0] < area[2] && tile->y[root] - area[1] < area[3];
  }
  return any;
}

/* Shares the work of a packet out among what its rays add to. */
PKTRT__COLD void pktrt__packet_share_cost(pktrt__tile *tile, const uint32_t *lane, uint32_t n, const pktrt_counts *c) {
  const pktrt_cost of = tile->render->desc->cost_of;
  const double each = (double)(of == PKTRT_COST_BOXES       ? c->box_tests
                               : of == PKTRT_COST_TRIANGLES ? c->triangle_tests
                                                            : c->vector_box_tests + c->vector_triangle_tests) /
                      n;
  for (uint32_t i = 0; i < n; i++) tile->cost[tile->pixel[pktrt__packet_root(tile, lane ? lane[i] : i)]] += each;
}

/* Traces rays as one packet (on the fast path as one batch) and adds to the statistics; `lane` as above. */
static void pktrt__packet_trace(pktrt__tile *tile, pktrt__batch *b, uint32_t n, pktrt_ray_type type, uint32_t depth,
                                bool occlusion, const uint32_t *lane) {
  const bool alone = tile->one_by_one;
  const pktrt__render_state *render = tile->render;
  pktrt_query_desc d;
  pktrt_counts counts;
  pktrt__query call = pktrt__query_make(render->scene, NULL, &d, occlusion);
  d.path = alone && render->desc->path == PKTRT_PATH_FAST ? PKTRT_PATH_SINGLE : render->desc->path;
  d.packet_size = alone ? 1 : n;
  if (render->desc->paper_steps) d.paper_steps = render->desc->paper_steps;
  if (PKTRT__STATS && d.path == PKTRT_PATH_PAPER && render->desc->trace && pktrt__packet_is_traced(tile, lane, n))
    d.trace = render->desc->trace, d.user = render->desc->user;
  const bool counted = PKTRT__STATS && (tile->stats || render->desc->cost);
  if (counted) memset(&counts, 0, sizeof counts), call.counts = &counts;
  pktrt__query_trace(&call, b, n);
  if (PKTRT__SURFACES && render->cutouts && !occlusion) pktrt__cutout_pass(render->scene, b, n);
  if (PKTRT__STATS && render->desc->cost) pktrt__packet_share_cost(tile, lane, n, &counts);
  if (!PKTRT__STATS || !tile->stats) return;
  pktrt__stats_add_counts(&tile->stats->by_type[type], &counts);
  pktrt__stats_add_counts(&tile->stats->by_depth[depth], &counts);
}

typedef enum pktrt__media_passage { PKTRT__STOPPED, PKTRT__GOES_ON, PKTRT__ARRIVED } pktrt__media_passage;
/* Lets shadow ray i of tile->glass_batch through the glass that it met: it loses what the surface reflects and the
   glass absorbs, and goes on along the same line as ray j. Anything but glass stops it. */
static pktrt__media_passage pktrt__media_pass_glass(pktrt__tile *tile, uint32_t i, uint32_t j, uint32_t hint[2],
                                                    uint32_t *media, float seen[3]) {
  const pktrt_scene *scene = tile->render->scene;
  pktrt__batch *b = &tile->glass_batch;
  const uint32_t mesh = pktrt__mesh_lookup(scene, b->id[i], b->place + i, hint),
                 triangle = b->id[i] - scene->meshes[mesh].first_id;
  const pktrt__mesh *m = &scene->meshes[mesh];
  const pktrt_material *mat = pktrt__material_of(scene, m->material);
  if (!tile->render->passes_glass || !pktrt__material_is_glass(scene, m)) return PKTRT__STOPPED;
  float origin[3], before[3];
  pktrt_ray ray;
  pktrt_hit hit;
  pktrt__spawn_point x;
  double along = 0, d2 = 0, n2 = 0;
  for (int a = 0; a < 3; a++)
    ray.origin[a] = b->o[a][i], ray.direction[a] = b->d[a][i], hit.normal[a] = b->as.hit.normal[a][i];
  hit.t = b->t[i], hit.u = b->as.hit.u[i], hit.v = b->as.hit.v[i];
  hit.mesh = mesh, hit.triangle = triangle, ray.tmin = 0, ray.tmax = INFINITY, ray.time = b->time[i];
  (void)pktrt__spawn_from(scene, &ray, &hit, NULL, &x);
  const float *d = ray.direction, *normal = hit.normal;
  for (int a = 0; a < 3; a++) {
    along += (double)normal[a] * (double)d[a];
    d2 += (double)d[a] * (double)d[a], n2 += (double)normal[a] * (double)normal[a];
  }
  const float cosine = (float)(fabs(along) / sqrt(d2 * n2));
  const float clear = 1 - pktrt_fresnel_dielectric(cosine, pktrt__material_ior(mat, 0));
  const pktrt__glass_mesh *glass = tile->render->glass_meshes;
  if (along > 0) *media = pktrt__media_know(scene, *media, pktrt__media_entry(scene, glass, mesh));
  for (int a = 0; a < 3; a++) {
    seen[a] *= clear;
    seen[a] *= pktrt__media_transmittance(scene, *media, a, (double)b->t[i] * sqrt(d2));
  }
  pktrt__spawn_origin(&x, along > 0 ? 1 : -1, origin), pktrt__spawn_origin(&x, along > 0 ? -1 : 1, before);
  *media = pktrt__media_pass_surface(scene, glass, *media, mesh, along > 0, before, origin, b->time[i]);
  const bool finite = b->tmax[i] < INFINITY;
  double left = 0;
  for (int a = 0; a < 3 && finite; a++) left += ((double)b->o[a][i] + (double)d[a] - (double)origin[a]) * (double)d[a];
  for (int a = 0; a < 3; a++) {
    const float end = b->o[a][i] + d[a];
    b->d[a][j] = finite ? end - origin[a] : d[a], b->o[a][j] = origin[a];
  }
  b->tmin[j] = 0, b->tmax[j] = b->tmax[i], b->time[j] = b->time[i];
  return !finite || left > 0 ? PKTRT__GOES_ON : PKTRT__ARRIVED;
}

/* Returns the glasses that pending shadow ray k starts in: those around the surface that it leaves. */
static uint32_t pktrt__media_of_sender(const pktrt__tile *tile, uint32_t k) {
  return tile->shaded->medium[tile->surfaces.first + tile->queue.target[k]];
}

/* Attenuates pending shadow ray k by the glass that ray i of a batch, its last piece, lies in; not if the light is
   infinitely far, for glass ends somewhere on the way. */
static void pktrt__media_dim(const pktrt_scene *scene, const pktrt__batch *b, uint32_t i, uint32_t media, uint32_t k,
                             pktrt__packet_queue *p) {
  if (!media || !(b->tmax[i] < INFINITY)) return;
  double d2 = 0;
  for (int a = 0; a < 3; a++) d2 += (double)b->d[a][i] * (double)b->d[a][i];
  for (int a = 0; a < 3; a++) p->visible[a][k] *= pktrt__media_transmittance(scene, media, a, sqrt(d2));
}

/* Attenuates the pending shadow rays that start in glass and meet nothing. */
static void pktrt__media_dim_unoccluded(pktrt__tile *tile, pktrt_ray_type type) {
  pktrt__packet_queue *p = &tile->queue;
  for (uint32_t k = 0; k < p->n; k++) {
    if (p->batch.slot[k] != PKTRT_NONE || (type == PKTRT_RAY_OTHER && p->wave[k])) continue;
    pktrt__media_dim(tile->render->scene, &p->batch, k, pktrt__media_of_sender(tile, k), k, p);
  }
}

/* Traces the listed pending shadow rays again, which something stopped, this time through glass. */
static void pktrt__media_trace_through_glass(pktrt__tile *tile, pktrt_ray_type type, uint32_t depth, uint32_t *lane,
                                             uint32_t listed) {
  pktrt__packet_queue *p = &tile->queue;
  pktrt__batch *b = &tile->glass_batch;
  uint32_t n = 0, hint[2] = {0, 0}, media[PKTRT__BATCH];
  for (uint32_t i = 0; i < listed; i++) {
    const uint32_t k = lane[i];
    if (type == PKTRT_RAY_OTHER && p->wave[k]) continue;
    media[n] = pktrt__media_of_sender(tile, k);
    for (int a = 0; a < 3; a++) b->o[a][n] = p->batch.o[a][k], b->d[a][n] = p->batch.d[a][k], p->visible[a][k] = 1;
    b->tmin[n] = 0, b->tmax[n] = p->batch.tmax[k], b->time[n] = p->batch.time[k];
    lane[n++] = k;
  }
  for (uint32_t round = 0; n && round <= 2 * PKTRT_MAX_DEPTH; round++) {
    uint32_t left = 0;
    pktrt__packet_trace(tile, b, n, type, depth, false, lane);
    for (uint32_t i = 0; i < n; i++) {
      const uint32_t k = lane[i];
      float seen[3] = {p->visible[0][k], p->visible[1][k], p->visible[2][k]};
      if (b->slot[i] == PKTRT_NONE) { /* nothing else on its way */
        pktrt__media_dim(tile->render->scene, b, i, media[i], k, p);
        continue;
      }
      const pktrt__media_passage passage = pktrt__media_pass_glass(tile, i, left, hint, &media[i], seen);
      for (int a = 0; a < 3; a++) {
        p->visible[a][k] = passage == PKTRT__STOPPED ? 0 : seen[a];
        if (tile->apart) p->contribution[a][k] = p->through[a][k];
      }
      if (passage == PKTRT__GOES_ON) media[left] = media[i], lane[left++] = k;
    }
    n = left;
  }
  for (uint32_t i = 0; i < n; i++) /* still in glass after the last round: stopped */
    for (int a = 0; a < 3; a++) p->visible[a][lane[i]] = 0;
}

PKTRT__COLD void pktrt__packet_tell(const pktrt__tile *tile, pktrt_ray_type type, uint32_t depth, uint32_t first) {
  const pktrt__packet_queue *p = &tile->queue;
  const pktrt__render_state *render = tile->render;
  uint32_t number[PKTRT__BATCH], x[PKTRT__BATCH], y[PKTRT__BATCH], sample[PKTRT__BATCH];
  for (uint32_t i = 0; i < p->n; i++) {
    const uint32_t root = pktrt__packet_root(tile, i);
    number[i] = (p->wave[i] ? p->wave[i]->parent[p->target[i]] : tile->surfaces.ray[p->target[i]]) - first;
    x[i] = tile->x[root], y[i] = tile->y[root], sample[i] = tile->pass * render->samples + tile->sample[root];
  }
  const uint32_t n = tile->one_by_one ? 1 : p->n;
  for (uint32_t i = 0; i < p->n; i += n) {
    pktrt_packet told = {type, depth, n, number + i, x + i, y + i, sample + i, {NULL, NULL, NULL}, {NULL, NULL, NULL}};
    for (int a = 0; a < 3; a++) told.origin[a] = p->batch.o[a] + i, told.direction[a] = p->batch.d[a] + i;
    render->desc->packet(render->desc->user, &told);
  }
}

/* Traces the pending rays. Shadow rays add their light in the order in which they were pushed; for each surface that is
   the order of the lights, whatever the packets. */
PKTRT__NOINLINE void pktrt__packet_flush(pktrt__tile *tile, pktrt_ray_type type, uint32_t depth) {
  pktrt__packet_queue *p = &tile->queue;
  pktrt__batch *b = &p->batch;
  pktrt__surfaces *s = &tile->surfaces;
  if (!p->n) return;
  if (tile->render->desc->packet) pktrt__packet_tell(tile, type, depth, tile->first);
  pktrt__packet_trace(tile, b, p->n, type, depth, type == PKTRT_RAY_SHADOW, NULL);
  if (type != PKTRT_RAY_SHADOW && type != PKTRT_RAY_OTHER) {
    pktrt__batch_copy_hits(&p->wave[0]->rays, p->target[0], b, 0, p->n); /* adjacent lanes of one wave */
    p->n = 0;
    return;
  }
  const pktrt__kernel_table *kernels = tile->render->scene->kernels;
  uint32_t lane[PKTRT__BATCH];
  const uint32_t listed = kernels->visibility(&tile->render->glass, b, p->visible, p->n, lane);
  if (PKTRT__DIELECTRIC && tile->in_glass) pktrt__media_dim_unoccluded(tile, type);
  if (listed) pktrt__media_trace_through_glass(tile, type, depth, lane, listed);
  if (type == PKTRT_RAY_SHADOW) kernels->add_direct_light(s, p->target, p->contribution, p->visible, p->n);
  for (uint32_t i = 0; type == PKTRT_RAY_OTHER && i < p->n; i++) {
    const uint32_t k = p->target[i];
    pktrt__wave *w = p->wave[i];
    if (!w) {
      for (int a = 0; a < 3; a++) s->radiance[a][k] += p->contribution[a][i] * p->visible[a][i];
      continue;
    }
    pktrt__batch_copy_hits(&w->rays, k, b, i, 1);
  }
  p->n = 0;
}

/* Appends rays [from, to) of the list of shadow rays, in the given order (NULL: as they are), to the pending ones. */
PKTRT__COLD void pktrt__packet_push_shadows(pktrt__tile *tile, const uint32_t *order, uint32_t from, uint32_t to) {
  pktrt__packet_queue *p = &tile->queue;
  const pktrt__shadow_rays *sh = &tile->shadow_rays;
  for (uint32_t i = from; i < to; i++) {
    const uint32_t at = p->n++, k = order ? order[i] : i;
    for (int a = 0; a < 3; a++) {
      p->batch.o[a][at] = sh->o[a][k], p->batch.d[a][at] = sh->d[a][k], p->contribution[a][at] = sh->contribution[a][k];
      if (tile->apart) p->through[a][at] = sh->through[a][k];
    }
    p->batch.tmax[at] = sh->tmax, p->batch.time[at] = sh->time[k];
    p->target[at] = sh->surface[k], p->wave[at] = NULL;
  }
}

/* Appends rays [from, to) of a wave to the pending ones. Only the first gets wave and lane, unless rays of several
   types may be pending or the packet hook needs them of each. */
static void pktrt__packet_push_wave(pktrt__tile *tile, pktrt__wave *w, uint32_t from, uint32_t to) {
  const pktrt__render_state *render = tile->render;
  pktrt__packet_queue *p = &tile->queue;
  const uint32_t n = p->n, m = to - from,
                 told = render->watched || render->desc->assembly == PKTRT_ASSEMBLY_BLIND ? m : 1;
  pktrt__batch_copy_rays(&p->batch, n, &w->rays, from, m);
  pktrt__fill_row(p->batch.tmax + n, m, INFINITY);
  for (uint32_t i = 0; i < told; i++) p->target[n + i] = from + i, p->wave[n + i] = w;
  p->n += m;
}

static uint32_t pktrt__packet_octant(float (*d)[PKTRT__ROW], uint32_t i) {
  return pktrt__sign_bit(d[0][i]) | pktrt__sign_bit(d[1][i]) << 1 | pktrt__sign_bit(d[2][i]) << 2;
}

/* Tells whether an assembly may change the order of rays. */
static bool pktrt__packet_reorders(pktrt_assembly assembly) {
  return assembly == PKTRT_ASSEMBLY_OCTANTS || assembly == PKTRT_ASSEMBLY_MATERIALS;
}

/* Sorts n rays of one type into packets (paper 3.2): writes tile->order, if that changes, and tile->packet, whose entry
   i is the end of the packet that begins at i. `sender` has the lanes of the rays that spawned them. */
static void pktrt__packet_assemble(pktrt__tile *tile, uint32_t n, float (*d)[PKTRT__ROW], const uint32_t *material,
                                   const uint32_t *sender) {
  const pktrt_assembly assembly = tile->render->desc->assembly;
  uint32_t *order = tile->order, *packet = tile->packet, placed = 0;
  const bool octants = assembly == PKTRT_ASSEMBLY_OCTANTS;
  if (pktrt__packet_reorders(assembly)) {
    uint8_t done[PKTRT__BATCH];
    memset(done, 0, n);
    for (uint32_t i = 0; i < n; i++) { /* the first ray that is left begins a packet */
      if (done[i]) continue;
      const uint32_t begin = placed;
      for (uint32_t j = i; j < n; j++) {
        if (done[j] ||
            (octants ? pktrt__packet_octant(d, j) != pktrt__packet_octant(d, i) : material[j] != material[i]))
          continue;
        done[j] = 1, order[placed++] = j;
      }
      packet[begin] = placed;
    }
  } else if (assembly == PKTRT_ASSEMBLY_RUNS) {
    for (uint32_t begin = 0, i = 1; i <= n; i++)
      if (i == n || material[i] != material[i - 1] || sender[i] != sender[i - 1] + 1) packet[begin] = i, begin = i;
  } else if (assembly == PKTRT_ASSEMBLY_NONE) {
    for (uint32_t i = 0; i < n; i++) packet[i] = i + 1;
  } else {
    packet[0] = n;
  }
}

/* Sorts the n rays of a wave into packets and moves them into that order. */
static void pktrt__packet_assemble_wave(pktrt__tile *tile, pktrt__wave **wave, uint32_t n) {
  pktrt__wave *w = *wave, *to = tile->spare;
  pktrt__packet_assemble(tile, n, w->rays.d, w->material, w->parent);
  if (!pktrt__packet_reorders(tile->render->desc->assembly)) return;
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t k = tile->order[i];
    pktrt__batch_copy_rays(&to->rays, i, &w->rays, k, 1);
    for (int a = 0; a < 3; a++) to->weight[a][i] = w->weight[a][k];
    to->importance[i] = w->importance[k], to->parent[i] = w->parent[k], to->key[i] = w->key[k];
    to->material[i] = w->material[k], to->medium[i] = w->medium[k], to->root[i] = w->root[k];
    to->density[i] = w->density[k], to->sky[i] = w->sky[k];
  }
  *wave = to, tile->spare = w;
}

/* >>direct --------------------------------------------------------------------------------------------------------- */

/* Fills in the samples that the rays to all surfaces belong to, and where the dimensions of their events begin. */
static void pktrt__sample_batch_of_surfaces(pktrt__tile *tile, const pktrt__wave *w) {
  pktrt__sample_batch *g = &tile->draws;
  const uint32_t groups = tile->render->event_dimensions / 4;
  for (uint32_t k = 0; k < tile->surfaces.count; k++) {
    const uint32_t ray = tile->surfaces.first + k, root = w->root[ray];
    g->x[k] = tile->x[root], g->y[k] = tile->y[root], g->sample[k] = tile->sample[root];
    g->group[k] = 2 + w->key[ray] * groups;
  }
  pktrt__sample_batch_end(g, tile->surfaces.count);
}

/* Tells whether surfaces at a depth ask one light for all. */
static bool pktrt__light_asks_one(const pktrt__render_state *render, uint32_t depth) {
  const pktrt_light_choice lights = render->desc->lights;
  return render->distribute && (lights == PKTRT_LIGHTS_ONE || (lights == PKTRT_LIGHTS_ONE_DEEPER && depth > 1));
}

PKTRT__NOINLINE void pktrt__light_view_of(const pktrt__wave *w, const pktrt__surfaces *s, uint32_t k,
                                          pktrt__light_view *v) {
  for (int a = 0; a < 3; a++) v->point[a] = s->point[a][k], v->normal[a] = (double)s->ns[a][k];
  v->time = w->rays.time[s->first + k];
}

/* Chooses a light for each surface. WHY level by level: what one surface waits for, a processor computes for others. */
static void pktrt__light_choose(pktrt__tile *tile, const pktrt__wave *w) {
  enum { TOGETHER = 64 };
  const pktrt__surfaces *s = &tile->surfaces;
  pktrt__light_descent at[TOGETHER];
  pktrt__light_view from[TOGETHER];
  pktrt__tile_draw_all(tile, 3, 1);
  for (uint32_t k = 0; k < s->count; k += TOGETHER) {
    const uint32_t n = s->count - k < (uint32_t)TOGETHER ? s->count - k : (uint32_t)TOGETHER;
    for (uint32_t i = 0; i < n; i++) {
      pktrt__light_view_of(w, s, k + i, &from[i]);
      pktrt__light_choose_part(tile->render, tile->cuts, &from[i], (double)tile->draws.u[3][k + i], &at[i]);
    }
    for (bool on = true; on;) {
      on = false;
      for (uint32_t i = 0; i < n; i++)
        if (at[i].n > 1) pktrt__light_choose_half(&from[i], &at[i]), on = true;
    }
    for (uint32_t i = 0; i < n; i++)
      tile->chosen[k + i] = tile->render->ordered[at[i].first], tile->share[k + i] = at[i].share;
  }
}

/* A look at lights. Those of a scene are looked at one after the other; or where surfaces ask one light for all, first those that
   are infinitely far, then the others. */
typedef struct pktrt__light_look {
  uint32_t light; /* PKTRT_NONE: what has been chosen, */
  bool infinite;  /* if it is (in)finitely far */
  bool lobes;     /* asks for what lobes meet, in place of samples */
} pktrt__light_look;

/* Returns the light that surface k looks at, or PKTRT_NONE, and how much more it counts for those that are not asked. */
static uint32_t pktrt__light_of_surface(const pktrt__tile *tile, const pktrt__light_look *look, uint32_t k,
                                        double *share) {
  *share = 1;
  if (look->light != PKTRT_NONE) return look->light;
  const uint32_t light = tile->chosen[k];
  *share = tile->share[k];
  return pktrt__light_has(&tile->render->scene->lights[light], PKTRT__LIGHT_INFINITE) == look->infinite ? light
                                                                                                        : PKTRT_NONE;
}

/* Tells whether lobes of surface k share a light between both ways to find it: what their rays cannot hit, always. */
static bool pktrt__light_is_shared(const pktrt__tile *tile, uint32_t light, uint32_t k) {
  const pktrt__surfaces *s = &tile->surfaces;
  const pktrt_light *l = &tile->render->scene->lights[light];
  if (!pktrt__render_uses(tile->render, PKTRT_FEATURE_GLOSS) || !pktrt__bit_of(s->lobed, k)) return false;
  return tile->render->follow && tile->render->distribute &&
         (pktrt__light_rows[l->kind].meet || (tile->render->lights[light].both && pktrt__bit_of(s->followed, k)));
}

/* Gets what arrives at n listed surfaces from directions d of the environment, relative to a light's strength. */
static void pktrt__light_list_sky(pktrt__tile *tile, const uint32_t *listed, uint32_t n, float (*d)[64]) {
  float radiance[3][64];
  pktrt__environment_radiance(tile->render, n, d, radiance);
  for (int a = 0; a < 3; a++)
    for (uint32_t i = 0; i < n; i++) tile->light_samples.arriving[a][listed[i]] *= radiance[a][i];
}

/* Samples a light for all surfaces, by the kernels; factors of those that take a closer look are -1. Tells whether
   there are any. */
static bool pktrt__light_sample_together(pktrt__tile *tile, uint32_t index) {
  const pktrt__render_state *render = tile->render;
  const pktrt__light_data *light = &render->lights[index];
  const pktrt__surfaces *s = &tile->surfaces;
  pktrt__light_samples *g = &tile->light_samples;
  const float *const u = tile->draws.u[2 * (index % 2)], *const v = tile->draws.u[2 * (index % 2) + 1];
  for (int a = 0; a < 3; a++) pktrt__fill_row(g->arriving[a], s->count, light->color[a]);
  const float shared = pktrt__to_float(1 / pktrt__max(light->strength, DBL_MIN));
  for (uint32_t k = 0; pktrt__render_uses(render, PKTRT_FEATURE_GLOSS) && k < s->count; k++)
    g->shared[k] = pktrt__light_is_shared(tile, index, k) ? shared : 0;
  return pktrt__fit_table_of(render->scene->desc.isa)
      ->sample_light(&render->scene->lights[index], &light->target, u, v, s, g);
}

/* Tells whether kernels know how to sample what surfaces look at. */
static bool pktrt__light_goes_together(const pktrt__render_state *render, const pktrt__light_look *look) {
  if (!PKTRT__AREA_LIGHTS || !render->distribute || look->light == PKTRT_NONE) return false;
  const pktrt_light_kind kind = render->scene->lights[look->light].kind;
  if (kind == PKTRT_LIGHT_ENVIRONMENT) return !(render->environment && render->environment->share > 0);
  return kind == PKTRT_LIGHT_QUAD || kind == PKTRT_LIGHT_SPHERE;
}

/* Samples a point of a light for surface k, for which it counts `share` times. */
static void pktrt__light_sample_one(pktrt__tile *tile, const pktrt__wave *w, const pktrt__light_look *look,
                                    uint32_t index, uint32_t k, double share) {
  const pktrt__render_state *render = tile->render;
  const pktrt_light *l = &render->scene->lights[index];
  const pktrt__light_data *light = &render->lights[index];
  pktrt__light_samples *g = &tile->light_samples;
  const bool area = pktrt__light_has(l, PKTRT__LIGHT_AREA), random = render->distribute && area;
  const uint32_t place = look->light == PKTRT_NONE ? 0 : 2 * (index % 2);
  const float u[2] = {random ? tile->draws.u[place][k] : 0, random ? tile->draws.u[place + 1][k] : 0};
  pktrt__light_view from;
  double at[3];
  pktrt__light_view_of(w, &tile->surfaces, k, &from);
  double factor = pktrt__light_rows[l->kind].sample(render, index, random ? u : NULL, &from, at);
  if (look->light == PKTRT_NONE && pktrt__light_has(l, PKTRT__LIGHT_BY_SQUARE) && !area)
    factor /= pktrt__distance2(from.point, at);
  for (int a = 0; a < 3; a++) g->at[a][k] = at[a], g->arriving[a][k] = light->color[a];
  g->factor[k] = factor * share * light->strength;
  g->shared[k] =
      pktrt__light_is_shared(tile, index, k) ? pktrt__to_float(1 / pktrt__max(light->strength * share, DBL_MIN)) : 0;
  if (look->light == PKTRT_NONE && pktrt__light_has(l, PKTRT__LIGHT_HIT)) g->shared[k] = -1;
}

/* Samples a point of a light for each surface, where that is random or takes more than the kernels know. */
static void pktrt__light_sample_each(pktrt__tile *tile, const pktrt__wave *w, const pktrt__light_look *look) {
  const pktrt__render_state *render = tile->render;
  const pktrt__surfaces *s = &tile->surfaces;
  pktrt__light_samples *g = &tile->light_samples;
  float d[3][64];
  uint32_t listed[64], n = 0;
  if (render->distribute) pktrt__tile_draw_all(tile, 4 + (look->light == PKTRT_NONE ? 0 : 2 * look->light), 2);
  const bool together = pktrt__light_goes_together(render, look);
  if (together && !pktrt__light_sample_together(tile, look->light) &&
      render->scene->lights[look->light].kind != PKTRT_LIGHT_ENVIRONMENT)
    return;
  for (uint32_t k = 0; k < s->count; k++) {
    double share;
    const uint32_t index = pktrt__light_of_surface(tile, look, k, &share);
    if (!together || g->factor[k] < 0) {
      g->factor[k] = 0, g->shared[k] = 0;
      if (index != PKTRT_NONE) pktrt__light_sample_one(tile, w, look, index, k, share);
    }
    if (index != PKTRT_NONE && render->scene->lights[index].kind == PKTRT_LIGHT_ENVIRONMENT) {
      for (int a = 0; a < 3; a++) d[a][n] = (float)g->at[a][k];
      listed[n++] = k;
    }
    if (n < 64 && (k + 1 < s->count || !n)) continue;
    pktrt__light_list_sky(tile, listed, n, d), n = 0;
  }
}

/* Finds where drawn directions of lobes meet a light that their rays do not. With p their density and q that of the
   light's samples, the light counts p / (p + q) of what the lobe has there: 1 / (p + q) per value of the lobe. Returns
   whether any do. */
static bool pktrt__light_meet_each(pktrt__tile *tile, const pktrt__wave *w, const pktrt__light_look *look) {
  const pktrt__render_state *render = tile->render;
  const pktrt__surfaces *s = &tile->surfaces;
  pktrt__light_samples *g = &tile->light_samples;
  bool any = false;
  for (uint32_t k = 0; k < s->count; k++) {
    double share, at[3], inverse = 0;
    const bool lobed = pktrt__bit_of(s->lobed, k) && s->density[k] > 0;
    const uint32_t index = lobed ? pktrt__light_of_surface(tile, look, k, &share) : PKTRT_NONE;
    g->factor[k] = 0, g->shared[k] = 0;
    if (index == PKTRT_NONE || !pktrt__light_rows[render->scene->lights[index].kind].meet) continue;
    const pktrt__light_data *light = &render->lights[index];
    const double direction[3] = {(double)s->lobe[0][k], (double)s->lobe[1][k], (double)s->lobe[2][k]};
    pktrt__light_view from;
    pktrt__light_view_of(w, s, k, &from);
    inverse = pktrt__light_rows[render->scene->lights[index].kind].meet(render, index, &from, direction, at);
    if (!(inverse > 0)) continue;
    for (int a = 0; a < 3; a++) g->at[a][k] = at[a], g->arriving[a][k] = light->color[a];
    g->factor[k] = light->strength * share / ((double)s->density[k] + 1 / inverse);
    any = true;
  }
  return any;
}

/* Returns the density of a Phong lobe at the cosine of an angle to its axis. */
static double pktrt__lobe_density(double exponent, double cosine) {
  /* cos^n <= exp(-n (1 - cos)): far from narrow lobes nothing is left of a float */
  if (!(cosine > 0) || (exponent < 65536 && exponent * (1 - cosine) > 128)) return 0;
  return (exponent + 1) * 0.15915494309189533577 * pktrt__math_power(pktrt__min(cosine, 1), exponent);
}
/* Returns the cosine of two vectors. WHY the division: unit vectors of float are not quite, and lobes of exponent 10^6
   became brighter or darker by a tenth. */
static double pktrt__lobe_cosine(double x, double y, double z, const pktrt__surfaces *s, uint32_t k) {
  const double to[3] = {x, y, z}, axis[3] = {(double)s->mirror[0][k], (double)s->mirror[1][k], (double)s->mirror[2][k]};
  return pktrt__dot(to, axis) / sqrt(pktrt__dot(to, to) * pktrt__dot(axis, axis));
}

/* Multiplies irradiances by the values of Phong lobes of surfaces i to i + 7 towards a light in direction `to`; 0 for
   those that have none. Where light is shared between its samples, of density q, and those of the lobe, whose value is its
   density p, samples count q / (p + q) of it: with x = p / q, x becomes x / (1 + x). */
static void pktrt__light_lobe_values(const pktrt_scene *scene, const pktrt__surfaces *s, uint32_t i, uint32_t lanes,
                                     float (*to)[8], const pktrt__light_samples *listed, float lobe[8]) {
  for (uint32_t j = 0; j < 8; j++) {
    double value = 0;
    if (lanes >> j & 1) {
      const double n = (double)pktrt__material_of(scene, s->material[i + j])->exponent;
      const double cosine = pktrt__lobe_cosine((double)to[0][j], (double)to[1][j], (double)to[2][j], s, i + j);
      value = pktrt__lobe_density(n, cosine) * pktrt__min((double)lobe[j], (double)FLT_MAX);
      const double shared = listed ? (double)listed->shared[i + j] : 0;
      value = shared < 0 ? 0 : value / (1 + value * shared);
    }
    lobe[j] = (float)value;
  }
}

/* Says where shadow rays go: into the list, or at once into the batch that is to be traced, which is empty then. */
static void pktrt__light_place_shadows(pktrt__tile *tile, bool at_once) {
  pktrt__shadow_rays *sh = &tile->shadow_rays;
  pktrt__shadow_list *l = &tile->shadow_list;
  pktrt__packet_queue *p = &tile->queue;
  for (int a = 0; a < 3; a++) {
    sh->o[a] = at_once ? p->batch.o[a] : l->o[a], sh->d[a] = at_once ? p->batch.d[a] : l->d[a];
    sh->contribution[a] = at_once ? p->contribution[a] : l->contribution[a];
    sh->through[a] = !tile->apart ? NULL : at_once ? p->through[a] : l->through[a];
  }
  sh->time = at_once ? p->batch.time : l->time, sh->surface = at_once ? p->target : l->surface;
  sh->material = at_once ? NULL : l->material, sh->tmax_row = at_once ? p->batch.tmax : NULL;
}

/* Makes the shadow rays of all surfaces towards a light. False: there are none. */
static bool pktrt__light_aim(pktrt__tile *tile, const pktrt__wave *w, const pktrt__light_look *look) {
  const pktrt__render_state *render = tile->render;
  const pktrt_scene *scene = render->scene;
  pktrt__light_target target;
  bool listed = true;
  if (look->light != PKTRT_NONE) {
    const pktrt_light *l = &scene->lights[look->light];
    target = render->lights[look->light].target;
    listed = (render->distribute && pktrt__light_has(l, PKTRT__LIGHT_AREA)) || pktrt__light_has(l, PKTRT__LIGHT_EACH);
  } else {
    memset(&target, 0, sizeof target);
    target.infinite = look->infinite, target.lobes = pktrt__render_uses(render, PKTRT_FEATURE_GLOSS);
  }
  target.glass_stops = tile->apart && look->light != PKTRT_NONE && render->lights[look->light].both;
  if (look->lobes) {
    if (!pktrt__light_meet_each(tile, w, look)) return false;
    target.lobes = target.lobes_only = true;
  } else if (listed) {
    pktrt__light_sample_each(tile, w, look);
  }
  if (listed) target.listed = &tile->light_samples;
  scene->kernels->shadow_rays(scene, &target, w, &tile->surfaces, &tile->shadow_rays);
  return tile->shadow_rays.count > 0;
}

/* Sends the shadow rays that have been made, in packets; `at_once`: they lie where they are traced. */
static void pktrt__light_send(pktrt__tile *tile, pktrt_ray_type type, uint32_t depth, bool at_once, bool together) {
  const pktrt__render_state *render = tile->render;
  const pktrt__shadow_rays *sh = &tile->shadow_rays;
  uint32_t *sender = tile->sender;
  if (at_once) {
    tile->queue.n = sh->count;
    pktrt__packet_flush(tile, type, depth);
    return;
  }
  for (uint32_t i = 0; render->desc->assembly == PKTRT_ASSEMBLY_RUNS && i < sh->count; i++)
    sender[i] = tile->surfaces.ray[sh->surface[i]];
  pktrt__packet_assemble(tile, sh->count, tile->shadow_list.d, sh->material, sender);
  for (uint32_t i = 0, end; i < sh->count; i = end) {
    end = tile->packet[i];
    for (uint32_t from = i, to; from < end; from = to) {
      const uint32_t room = PKTRT__BATCH - tile->queue.n;
      to = end - from < room ? end : from + room;
      pktrt__packet_push_shadows(tile, pktrt__packet_reorders(render->desc->assembly) ? tile->order : NULL, from, to);
      if (tile->queue.n == PKTRT__BATCH) pktrt__packet_flush(tile, type, depth);
    }
    if (!together) pktrt__packet_flush(tile, type, depth);
  }
}

/* Adds direct light to all surfaces.

   What a lobe gets of a light with extent is found in two ways, whose weights sum up to 1 for each direction (the balance
   heuristic, Veach and Guibas 1995): by samples of the light, good for wide lobes, and by the direction drawn from the
   lobe, good for narrow ones. Quads and spheres are nothing that rays hit: drawn directions that meet them are aimed
   at as samples are. Meshes and the environment are found by the reflected ray, if it is followed, which takes the
   density of its direction along. That ray is bent by glass, and so glass stops what of samples shares with it. */
PKTRT__NOINLINE void pktrt__light_add_direct(pktrt__tile *tile, const pktrt__wave *w, uint32_t depth) {
  const pktrt__render_state *render = tile->render;
  const bool blind = render->desc->assembly == PKTRT_ASSEMBLY_BLIND;
  const bool together = blind || render->desc->shadows == PKTRT_SHADOWS_TOGETHER;
  const bool at_once = render->desc->assembly == PKTRT_ASSEMBLY_RAY_TYPES && !together && !render->watched;
  const bool lobes = render->follow && render->distribute && pktrt__render_uses(render, PKTRT_FEATURE_GLOSS),
             one = pktrt__light_asks_one(render, depth);
  const pktrt_ray_type type = blind ? PKTRT_RAY_OTHER : PKTRT_RAY_SHADOW;
  const uint32_t lights = render->scene->light_count, looks = one && lights ? 2 : lights;
  tile->apart = lobes && !one && render->passes_glass;
  pktrt__light_place_shadows(tile, at_once);
  if (one && lights) pktrt__light_choose(tile, w);
  for (uint32_t i = 0; i < looks; i++) {
    pktrt__light_look look = {one ? PKTRT_NONE : i, i == 0, false};
    if (pktrt__light_aim(tile, w, &look)) pktrt__light_send(tile, type, depth, at_once, together);
    look.lobes = true;
    if (lobes && (one ? i > 0 : pktrt__light_rows[render->scene->lights[i].kind].meet != NULL) &&
        pktrt__light_aim(tile, w, &look))
      pktrt__light_send(tile, type, depth, at_once, together);
  }
  if (!blind) pktrt__packet_flush(tile, type, depth);
}

/* >>scattering: the rays of the next generation -------------------------------------------------------------------- */

static pktrt__wave *pktrt__wave_need(pktrt__tile *tile, pktrt__wave **wave) {
  if (!*wave) *wave = PKTRT__CAST(pktrt__wave *, pktrt__mem_alloc(&tile->render->scene->desc, 1, sizeof **wave));
  if (!*wave) tile->failed = true;
  return *wave;
}

/* Returns the glasses that the refracted ray of surface k is in. */
static uint32_t pktrt__media_behind(const pktrt__spawn_request *g, const pktrt__wave *w, const pktrt__surfaces *s,
                                    uint32_t k) {
  float before[3], behind[3];
  for (int a = 0; a < 3; a++) {
    const double off = (double)s->offset[k] * (double)s->ng[a][k];
    before[a] = (float)(s->point[a][k] + off), behind[a] = (float)(s->point[a][k] - off);
  }
  const uint32_t media = pktrt__media_before(g->scene, g->glass, w, s, k);
  return pktrt__media_pass_surface(g->scene, g->glass, media, s->mesh[k], pktrt__bit_of(s->inside, k), before, behind,
                                   w->rays.time[s->first + k]);
}

/* Finds sample keys and glasses of the rays from surfaces i to i + 7. Reflected rays stay in the glasses before. */
static void pktrt__spawn_inherit(const pktrt__spawn_request *g, const pktrt__wave *w, const pktrt__surfaces *s,
                                 uint32_t i, uint32_t lanes, uint32_t medium[8], uint32_t key[8]) {
  const uint32_t lane = s->first + i;
  for (uint32_t j = 0; j < 8; j++) {
    medium[j] = w->medium[lane + j];
    key[j] = (w->key[lane + j] + 1) * g->times + g->plus;
  }
  for (lanes &= s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8]; lanes; lanes &= lanes - 1) {
    const uint32_t j = pktrt__lowest_bit(lanes);
    medium[j] =
        g->refraction ? pktrt__media_behind(g, w, s, i + j) : pktrt__media_before(g->scene, g->glass, w, s, i + j);
  }
}

/* Draws a direction within the lobe of surface k. If it points below the surface, its density is 0. */
static void pktrt__spawn_draw_lobe(pktrt__tile *tile, const pktrt__wave *w, uint32_t k, uint32_t depth) {
  const pktrt__render_state *render = tile->render;
  pktrt__surfaces *s = &tile->surfaces;
  const pktrt_material *mat = pktrt__material_of(render->scene, s->material[k]);
  const float axis[3] = {s->mirror[0][k], s->mirror[1][k], s->mirror[2][k]};
  const float u[2] = {tile->draws.u[0][k], tile->draws.u[1][k]};
  const float largest = pktrt__maxf(s->reflected[0][k], pktrt__maxf(s->reflected[1][k], s->reflected[2][k]));
  const bool followed = depth < render->max_depth && !pktrt__light_asks_one(render, depth + 1) &&
                        !(w->importance[s->first + k] * largest < render->threshold);
  float out[3], side = 0;
  if (render->desc->phong_mapping == PKTRT_PHONG_NAIVE) pktrt_map_phong_naive(u, axis, mat->exponent, out);
  else pktrt_map_phong(u, axis, mat->exponent, out);
  for (int a = 0; a < 3; a++) side += out[a] * s->ng[a][k], s->lobe[a][k] = out[a];
  if (followed) s->followed[k / 8] = (uint8_t)(s->followed[k / 8] | 1u << k % 8);
  if (!(side > 0)) return;
  s->density[k] = 1; /* any: who asks for more? */
  if (!render->two_ways) return;
  const double cosine = pktrt__lobe_cosine((double)out[0], (double)out[1], (double)out[2], s, k);
  const double density = pktrt__min(pktrt__max(pktrt__lobe_density((double)mat->exponent, cosine), FLT_MIN), FLT_MAX);
  s->density[k] = (float)density;
  if (!followed) return;
  s->shared[k] = (float)density;
  if (render->sky_light == PKTRT_NONE) return;
  const double d[3] = {(double)out[0], (double)out[1], (double)out[2]};
  pktrt__light_view from;
  pktrt__light_view_of(w, s, k, &from);
  s->sky[k] = (float)(density / (density + pktrt__light_environment_density(render, &from, d)));
}

/* Turns reflected rays of lobes to the directions that were drawn. */
static void pktrt__spawn_turn_to_lobes(pktrt__surfaces *s) {
  for (uint32_t k = 0; k < s->count; k++)
    for (int a = 0; pktrt__bit_of(s->lobed, k) && a < 3; a++) {
      s->mirror[a][k] = s->lobe[a][k];
      if (!(s->density[k] > 0)) s->reflected[a][k] = 0;
    }
}

/* Tells whether one way is chosen at all glass where rays of a wave end. */
static bool pktrt__spawn_chooses(const pktrt__tile *tile, const pktrt__wave *w) {
  const bool first = tile->render->splits || tile->render->desc->branching == PKTRT_BRANCHING_FIRST;
  return tile->render->choose && !(first && w == &tile->primary);
}

/* Tells whether surface k of glass, where one way may be chosen, sends both rays. */
static bool pktrt__spawn_splits(pktrt__tile *tile, const pktrt__wave *w, uint32_t k) {
  const uint32_t ray = tile->surfaces.ray[k]; /* that of a primary wave is its root */
  if (pktrt__spawn_chooses(tile, w) || !tile->split[tile->pixel[ray]]) return false;
  tile->fresnel[ray] = tile->surfaces.fresnel[k];
  return true;
}

/* Makes the random choices of surfaces: a direction within each lobe; one of the two rays at glass. */
static void pktrt__spawn_scatter(pktrt__tile *tile, const pktrt__wave *w, uint32_t depth) {
  pktrt__surfaces *s = &tile->surfaces;
  const bool gloss = pktrt__render_uses(tile->render, PKTRT_FEATURE_GLOSS) && tile->render->distribute;
  uint32_t drawn = 0;
  if (gloss) {
    memset(s->followed, 0, sizeof s->followed), pktrt__fill_row(s->density, s->count, 0);
    pktrt__fill_row(s->shared, s->count, 0), pktrt__fill_row(s->sky, s->count, 1);
  }
  for (uint32_t i = 0; i < s->count; i += 8) {
    uint32_t lobes = gloss ? s->lobed[i / 8] : 0;
    uint32_t glass = PKTRT__DIELECTRIC && tile->render->choose ? s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8] & ~lobes : 0;
    if ((lobes | glass) && i >= drawn) {
      drawn = i - i % PKTRT__DRAWN;
      pktrt__tile_draw(tile, drawn, 0, 2), drawn += PKTRT__DRAWN;
    }
    for (; lobes; lobes &= lobes - 1) pktrt__spawn_draw_lobe(tile, w, i + pktrt__lowest_bit(lobes), depth);
    for (; glass; glass &= glass - 1) {
      const uint32_t k = i + pktrt__lowest_bit(glass);
      if (pktrt__spawn_splits(tile, w, k)) continue;
      const bool refraction = tile->draws.u[0][k] >= s->fresnel[k];
      for (int a = 0; a < 3; a++) {
        s->reflected[a][k] = refraction ? 0 : s->reflected[a][k] / s->fresnel[k];
        s->transmitted[a][k] = refraction ? s->transmitted[a][k] / (1 - s->fresnel[k]) : 0;
      }
    }
  }
}

/* Appends the reflected or refracted rays of all surfaces to the n of a wave. Returns how many it has then. Where glass
   branches, the two subtrees use different dimensions. */
static uint32_t pktrt__spawn_wave(const pktrt__tile *tile, const pktrt__wave *w, bool refraction, pktrt__wave *to,
                                  uint32_t n) {
  const pktrt__render_state *render = tile->render;
  const bool apart = refraction && !pktrt__spawn_chooses(tile, w);
  pktrt__spawn_request g;
  g.scene = render->scene, g.glass = render->glass_meshes;
  g.refraction = refraction, g.threshold = render->threshold;
  g.lobes = render->distribute && pktrt__render_uses(render, PKTRT_FEATURE_GLOSS);
  g.times = apart ? 0x9E3779B1u : 1, g.plus = apart ? 0x85EBCA6Bu : 0;
  return (render->scene->kernels->spawn_rays)(&g, w, &tile->surfaces, to, n);
}

/* >>generations ---------------------------------------------------------------------------------------------------- */

static void pktrt__wave_shade(pktrt__tile *tile, pktrt__wave *w, uint32_t first, uint32_t n, uint32_t depth);

/* Traces rays [first, first + n) of a wave of `all`, which are of one type, as one packet: where they lie if they are the
   whole wave, or else from a copy, for lanes behind a packet are padded. Who watches looks at the copy. */
static void pktrt__wave_trace(pktrt__tile *tile, pktrt__wave *w, uint32_t first, uint32_t n, uint32_t all,
                              uint32_t depth, pktrt_ray_type type) {
  if (n < all || tile->render->watched) {
    pktrt__packet_push_wave(tile, w, first, first + n);
    pktrt__packet_flush(tile, type, depth);
    return;
  }
  pktrt__fill_row(w->rays.tmin, n, 0);
  pktrt__fill_row(w->rays.tmax, n, INFINITY);
  pktrt__packet_trace(tile, &w->rays, n, type, depth, false, NULL);
}

/* --- splitting ---

   Where a primary ray ends at glass of Fresnel reflectance F, let r and t be what its reflected and its refracted ray
   add if both are followed. If one is chosen by F the pixel gets r / F or t / (1 - F), whose mean is the same and whose
   variance is more by F (1 - F) (r / F - t / (1 - F))^2. Adaptive renders follow both in the passes that all cells get,
   and sum that up. A cell of which a part g of the samples splits has, with both, about 1 + 2 g trees of rays a sample,
   else 1 + g. Time times variance is less with both, and later passes follow both, where (V + D) (1 + g) > V (1 + 2 g),
   V being the variance of a pass with both, D what choosing would add. Numbers of rays decide, not clocks: bits are
   the same on all machines. */

/* Notes which of the n rays of a wave from the first glass are refracted. WHY before they are shaded: keys move then. */
static void pktrt__split_mark(pktrt__tile *tile, const pktrt__wave *w, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) tile->refracts[i] = w->key[i] != 1; /* reflected rays take the next key */
}
/* Notes what these rays have added: r / F - t / (1 - F). */
static void pktrt__split_note(pktrt__tile *tile, const pktrt__wave *w, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t from = w->parent[i];
    const float f = tile->fresnel[from], part = tile->refracts[i] ? f - 1 : f;
    for (int a = 0; f > 0 && f < 1 && a < 3; a++) tile->fork[a][from] += w->weight[a][i] * w->radiance[a][i] / part;
  }
}
/* Adds for the pixels of the n primary rays what following both was worth: D, and how often. */
static void pktrt__split_end(pktrt__tile *tile, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    const float f = tile->fresnel[i], *const x = tile->fork[0], *const y = tile->fork[1], *const z = tile->fork[2];
    if (!(f > 0 && f < 1)) continue;
    tile->gain[tile->pixel[i]] += f * (1 - f) * (x[i] * x[i] + y[i] * y[i] + z[i] * z[i]);
    tile->splits[tile->pixel[i]]++;
  }
}

/* Traces and shades the n rays of a wave packet by packet, with all generations that follow, and adds their weighted
   radiance to the rays of the parent wave. Rays from `split` on are refracted; they are traced with the others unless
   statistics or the packet hook tell them apart. */
static void pktrt__wave_follow(pktrt__tile *tile, pktrt__wave *parent, pktrt__wave **wave, uint32_t n, uint32_t split,
                               uint32_t depth, pktrt_ray_type type) {
  if (!n) return;
  if (!(PKTRT__STATS && tile->stats) && !tile->render->watched) split = n;
  const uint32_t first = tile->first;
  const bool traced = type == PKTRT_RAY_OTHER;
  if (!traced) pktrt__packet_assemble_wave(tile, wave, n);
  pktrt__wave *w = *wave;
  if (traced)
    for (uint32_t i = 0; i < n; i += PKTRT__BATCH / 2) w->end[i] = n - i < PKTRT__BATCH / 2 ? n : i + PKTRT__BATCH / 2;
  else memcpy(w->end, tile->packet, n * sizeof *w->end);
  for (uint32_t i = 0; PKTRT__STATS && tile->stats && i < n; i++)
    if (tile->deepest[w->root[i]] < depth) tile->deepest[w->root[i]] = (uint8_t)depth;
  const bool splits = tile->render->splits && depth == 1;
  if (splits) pktrt__split_mark(tile, w, n);
  for (uint32_t i = 0; i < n; i = w->end[i]) {
    tile->first = first, tile->one_by_one = tile->render->desc->assembly == PKTRT_ASSEMBLY_NONE;
    if (!traced && split < n) { /* by ray types: one packet */
      pktrt__wave_trace(tile, w, 0, split, n, depth, PKTRT_RAY_REFLECTION);
      pktrt__wave_trace(tile, w, split, n - split, n, depth, PKTRT_RAY_REFRACTION);
    } else if (!traced) {
      pktrt__wave_trace(tile, w, i, w->end[i] - i, n, depth, type);
    }
    pktrt__wave_shade(tile, w, i, w->end[i] - i, depth);
  }
  if (splits) pktrt__split_note(tile, w, n);
  for (int a = 0; a < 3; a++)
    for (uint32_t i = 0; i < n; i++) parent->radiance[a][w->parent[i]] += w->weight[a][i] * w->radiance[a][i];
}

/* Traces all rays that a packet spawned together with its shadow rays, as one packet (assembly `blind`). */
static void pktrt__packet_push_blindly(pktrt__tile *tile, pktrt__wave *w, uint32_t n, uint32_t depth) {
  for (uint32_t i = 0; i < n;) {
    const uint32_t room = PKTRT__BATCH - tile->queue.n, m = n - i < room ? n - i : room;
    pktrt__packet_push_wave(tile, w, i, i + m);
    i += m;
    if (tile->queue.n == PKTRT__BATCH) pktrt__packet_flush(tile, PKTRT_RAY_OTHER, depth);
  }
  pktrt__packet_flush(tile, PKTRT_RAY_OTHER, depth);
}

static bool pktrt__media_any(const pktrt__wave *w, const pktrt__surfaces *s) {
  uint32_t any = 0;
  for (uint32_t k = 0; k < s->count; k++) any |= w->medium[s->first + k];
  return any != 0;
}
static uint32_t pktrt__surface_count_glass(const pktrt__surfaces *s) {
  uint32_t n = 0;
  for (uint32_t i = 0; i < s->count; i += 8) n += pktrt__popcount8(s->kind[PKTRT_SPECULAR_DIELECTRIC][i / 8]);
  return n;
}

/* Computes the radiance along rays [first, first + n) of a wave, which have been traced: emission and direct light of
   their surfaces first, then by recursion the light along the rays that these spawn into waves of the next depth. */
static void pktrt__wave_shade(pktrt__tile *tile, pktrt__wave *w, uint32_t first, uint32_t n, uint32_t depth) {
  const pktrt__render_state *render = tile->render;
  pktrt__surfaces *s = &tile->surfaces;
  const bool blind = render->desc->assembly == PKTRT_ASSEMBLY_BLIND;
  uint32_t reflected = 0, refracted = 0;
  bool one_wave = blind;
  if (pktrt__tile_is_stopped(tile)) return;
  pktrt__surface_gather(tile, w, first, n, depth);
  if (!s->count) return;
  pktrt__tile_evaluate_materials(tile, w, depth);
  if (render->draws) pktrt__sample_batch_of_surfaces(tile, w);
  tile->first = first, tile->one_by_one = render->desc->assembly == PKTRT_ASSEMBLY_NONE;
  tile->shaded = w, tile->in_glass = pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC) && pktrt__media_any(w, s);
  const bool lobes = render->follow && render->distribute && pktrt__render_uses(render, PKTRT_FEATURE_GLOSS);
  if (render->follow && render->draws && (lobes || depth < render->max_depth)) pktrt__spawn_scatter(tile, w, depth);
  pktrt__light_add_direct(tile, w, depth + 1);
  if (render->follow && depth < render->max_depth && !tile->failed) {
    pktrt__wave *r = pktrt__wave_need(tile, &tile->reflected[depth]), *t = r;
    if (lobes) pktrt__spawn_turn_to_lobes(s);
    if (!tile->failed && pktrt__wave_need(tile, &tile->spare)) reflected = pktrt__spawn_wave(tile, w, false, r, 0);
    const uint32_t most = pktrt__spawn_chooses(tile, w) ? s->count : reflected + pktrt__surface_count_glass(s);
    one_wave = one_wave || (tile->large_waves && most <= PKTRT__BATCH);
    const bool glass = pktrt__render_uses(render, PKTRT_FEATURE_DIELECTRIC);
    if (glass && !one_wave) t = pktrt__wave_need(tile, &tile->refracted[depth]);
    if (one_wave) refracted = reflected;
    if (glass && !tile->failed) refracted = pktrt__spawn_wave(tile, w, true, t, refracted);
  }
  if (blind) pktrt__packet_push_blindly(tile, tile->reflected[depth], refracted, depth + 1);
  for (int a = 0; a < 3; a++) {
    if (s->count == n) memcpy(w->radiance[a] + first, s->radiance[a], n * sizeof(float));
    for (uint32_t k = 0; s->count < n && k < s->count; k++) w->radiance[a][s->ray[k]] = s->radiance[a][k];
  }
  if (one_wave) {
    const pktrt_ray_type type = blind ? PKTRT_RAY_OTHER : reflected ? PKTRT_RAY_REFLECTION : PKTRT_RAY_REFRACTION;
    pktrt__wave_follow(tile, w, &tile->reflected[depth], refracted, reflected ? reflected : refracted, depth + 1, type);
    return;
  }
  pktrt__wave_follow(tile, w, &tile->reflected[depth], reflected, reflected, depth + 1, PKTRT_RAY_REFLECTION);
  tile->first = first;
  pktrt__wave_follow(tile, w, &tile->refracted[depth], refracted, refracted, depth + 1, PKTRT_RAY_REFRACTION);
}

/* >>tiles ---------------------------------------------------------------------------------------------------------- */

/* Draws the places of the n samples of the primary wave in pixel and on lens, from the first four dimensions, and their
   times within the shutter, which its rays get. Without a lens one of its dimensions gives the time. */
static void pktrt__tile_draw_camera(pktrt__tile *tile, uint32_t n, bool lens, bool shutter) {
  pktrt__sample_batch *g = &tile->draws;
  memcpy(g->x, tile->x, n * sizeof *g->x), memcpy(g->y, tile->y, n * sizeof *g->y);
  memcpy(g->sample, tile->sample, n * sizeof *g->sample), memset(g->group, 0, n * sizeof *g->group);
  pktrt__sample_batch_end(g, n);
  if (lens && shutter) pktrt__tile_draw_all(tile, 4, 1), memcpy(tile->primary.rays.time, g->u[0], n * sizeof(float));
  pktrt__tile_draw_all(tile, 0, lens ? 4 : shutter ? 3 : 2);
  if (!lens && shutter) memcpy(tile->primary.rays.time, g->u[2], n * sizeof(float));
}

PKTRT__INLINE double pktrt__camera_shutter_time(const pktrt_camera *c, float part) {
  return pktrt__min(1, (double)c->time + (double)part * (double)c->shutter);
}

/* Makes the camera rays of the n samples of the primary wave, whose pixels are set. */
static void pktrt__tile_camera_rays(pktrt__tile *tile, uint32_t n) {
  const pktrt__render_state *render = tile->render;
  const pktrt_camera *c = &render->desc->camera;
  pktrt__wave *w = &tile->primary;
  const pktrt__sample_batch *g = &tile->draws;
  const bool lens = pktrt__render_uses(render, PKTRT_FEATURE_LENS),
             shutter = pktrt__render_uses(render, PKTRT_FEATURE_SHUTTER);
  const bool pinhole = !lens && !(PKTRT__MOTION && c->moving);
  double x[8] = {0, 0, 0, 0, 0, 0, 0, 0}, y[8] = {0, 0, 0, 0, 0, 0, 0, 0};
  const float middle = (float)pktrt__camera_shutter_time(c, 0.5f);
  pktrt__fill_row(w->importance, n, 1);
  memcpy(w->parent, tile->surfaces.number, n * sizeof *w->parent);
  memcpy(w->root, tile->surfaces.number, n * sizeof *w->root);
  memset(w->key, 0, n * sizeof *w->key), memset(w->medium, 0, n * sizeof *w->medium);
  memset(w->material, 0, n * sizeof *w->material), memset(tile->deepest, 0, n);
  if (render->sky_light != PKTRT_NONE) pktrt__fill_row(w->sky, n, 1);
  if (render->random) pktrt__tile_draw_camera(tile, n, lens, shutter);
  for (uint32_t i = 0; i < n; i += 8) {
    const uint32_t m = n - i < 8 ? n - i : 8;
    for (uint32_t k = 0; k < m; k++) {
      w->rays.time[i + k] = shutter ? (float)pktrt__camera_shutter_time(c, w->rays.time[i + k]) : middle;
      x[k] = (double)tile->x[i + k] + (render->random ? (double)g->u[0][i + k] : 0.5);
      y[k] = (double)tile->y[i + k] + (render->random ? (double)g->u[1][i + k] : 0.5);
    }
    if (pinhole) render->scene->kernels->camera_rays(&render->plane, x, y, w, i);
    for (uint32_t k = 0; !pinhole && k < m; k++) {
      const float u[2] = {lens ? g->u[2][i + k] : 0.5f, lens ? g->u[3][i + k] : 0.5f};
      pktrt__camera_sample sample = {x[k], y[k], (double)w->rays.time[i + k], {0, 0}};
      float o[3], d[3];
      if (lens) pktrt_map_disk(u, sample.disk);
      pktrt__camera_ray_at(c, render->desc->width, render->desc->height, &render->plane, &sample, o, d);
      for (int a = 0; a < 3; a++) w->rays.o[a][i + k] = o[a], w->rays.d[a][i + k] = d[a];
    }
  }
}

/* Finds the glasses that the n rays of the primary wave start in; rays of one origin and time share what was found. */
static void pktrt__media_start_in_glass(pktrt__tile *tile, uint32_t n) {
  pktrt__wave *w = &tile->primary;
  for (uint32_t i = 0; i < n; i++) {
    const float o[3] = {w->rays.o[0][i], w->rays.o[1][i], w->rays.o[2][i]};
    bool same = i > 0 && w->rays.time[i] == w->rays.time[i - 1];
    for (int a = 0; same && a < 3; a++) same = o[a] == w->rays.o[a][i - 1];
    w->medium[i] = same ? w->medium[i - 1]
                        : pktrt__media_around(tile->render->scene, tile->render->glass_meshes, o, w->rays.time[i]);
  }
}

/* Traces and shades the n rays of the primary wave and adds them up by pixel, in the order of their samples. */
PKTRT__NOINLINE void pktrt__tile_run_wave(pktrt__tile *tile, uint32_t n) {
  pktrt__wave *w = &tile->primary;
  tile->one_by_one = false, tile->first = 0;
  pktrt__tile_camera_rays(tile, n);
  if (tile->render->splits) memset(tile->fresnel, 0, sizeof tile->fresnel), memset(tile->fork, 0, sizeof tile->fork);
  if (PKTRT__DIELECTRIC && tile->render->starts_in_glass) pktrt__media_start_in_glass(tile, n);
  pktrt__wave_trace(tile, w, 0, n, n, 0, PKTRT_RAY_PRIMARY);
  const bool blind =
      tile->render->desc->assembly == PKTRT_ASSEMBLY_BLIND; /* reflected and refracted rays share a wave */
  const uint32_t step = blind ? PKTRT__BATCH / 2 : PKTRT__BATCH;
  for (uint32_t i = 0; i < n; i += step) pktrt__wave_shade(tile, w, i, n - i < step ? n - i : step, 0);
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) tile->sum[a][tile->pixel[i]] += (double)w->radiance[a][i];
  if (tile->render->splits && tile->pass < PKTRT__PILOT) pktrt__split_end(tile, n);
  if (!PKTRT__STATS || !tile->stats) return;
  tile->stats->samples += n;
  for (uint32_t i = 0; i < n; i++) tile->stats->tree_depth += tile->deepest[i];
}

/* Writes the AOVs of a finished pixel, means of n samples, to the optional buffers. */
static void pktrt__aov_write(const pktrt_render_desc *d, const pktrt__aov_sums *sums, double n, size_t at) {
  for (size_t a = 0; a < 3; a++) {
    if (d->normal) d->normal[at * 3 + a] = (float)(sums->normal[a] / n);
    if (d->albedo) d->albedo[at * 3 + a] = (float)(sums->albedo[a] / n);
  }
  if (d->depth) d->depth[at] = sums->met > 0 ? (float)(sums->depth / sums->met) : INFINITY;
}

/* Adds the AOVs of pixel p of the block to those of the passes before, and writes their means. */
static void pktrt__aov_add_pixel(const pktrt__tile *tile, pktrt__aov_sums *before, uint32_t p, size_t at) {
  pktrt__aov_sums one, *to = before ? before : &one;
  if (!before) memset(&one, 0, sizeof one);
  to->depth += tile->depth[p], to->met += tile->hit_count[p];
  for (int a = 0; a < 3; a++) to->normal[a] += tile->normal[a][p], to->albedo[a] += tile->albedo[a][p];
  pktrt__aov_write(tile->render->desc, to, (double)(tile->pass + 1) * tile->render->samples, at);
}

PKTRT__INLINE void pktrt__pass_add(const double mean[3], double sum[3], double *squares) {
  for (int a = 0; a < 3; a++) sum[a] += mean[a], *squares += mean[a] * mean[a];
}
PKTRT__INLINE void pktrt__pass_write_mean(const double sum[3], double passes, float *pixel) {
  for (int a = 0; a < 3; a++) pixel[a] = pktrt__to_float(sum[a] / passes);
}

/* Writes the means of finished pixels to the picture and the optional buffers. WHY not inlined, as waves: the loop over samples
   keeps its registers. */
PKTRT__NOINLINE void pktrt__tile_write_pixels(const pktrt__tile *tile, const uint32_t *x, const uint32_t *y,
                                              uint32_t pixels) {
  const pktrt_render_desc *d = tile->render->desc;
  const pktrt__pass_sums *passes = tile->render->passes;
  const bool notes = pktrt__aov_wanted(tile->render), alone = tile->render->samples == 1; /* divisions take time */
  const double n = tile->render->samples;
  for (uint32_t p = 0; p < pixels; p++) {
    float *to = tile->render->sums_only ? NULL : d->pixels + y[p] * tile->render->row_stride + (size_t)x[p] * 3;
    const size_t at = (size_t)y[p] * d->width + x[p];
    const size_t own = passes ? (size_t)(y[p] - passes->y) * passes->w + (x[p] - passes->x) : 0;
    double mean[3];
    for (int a = 0; a < 3; a++) mean[a] = alone ? tile->sum[a][p] : tile->sum[a][p] / n;
    if (passes) pktrt__pass_add(mean, passes->sums[own].mean, &passes->sums[own].squares);
    if (passes && !tile->render->sums_only) pktrt__pass_write_mean(passes->sums[own].mean, tile->pass + 1, to);
    if (tile->render->splits) passes->sums[own].gain += tile->gain[p], passes->sums[own].splits += tile->splits[p];
    for (int a = 0; !passes && a < 3; a++) to[a] = pktrt__to_float(mean[a]);
    if (notes) pktrt__aov_add_pixel(tile, passes ? &passes->aovs[own] : NULL, p, at);
    if (d->cost) {
      const double before = tile->pass ? (double)d->cost[at] : 0;
      d->cost[at] = (float)(before + (tile->cost[p] / n - before) / (tile->pass + 1));
    }
    if (d->sample_count) d->sample_count[at] = (tile->pass + 1) * tile->render->samples;
  }
}

/* Sets which pixels of a list send both rays from their first glass in this pass. */
static void pktrt__split_begin(pktrt__tile *tile, const uint32_t *x, const uint32_t *y, uint32_t pixels) {
  const bool all = !tile->render->splits || tile->pass < PKTRT__PILOT;
  const pktrt__pass_sums *p = tile->render->passes;
  memset(tile->gain, 0, sizeof tile->gain), memset(tile->splits, 0, sizeof tile->splits);
  for (uint32_t i = 0; i < pixels; i++)
    tile->split[i] =
        all || p->cells[(size_t)(y[i] / PKTRT__PASS_CELL) * p->cell_columns + x[i] / PKTRT__PASS_CELL].split;
}

/* Renders a list of pixels, waves of `room` rays. */
static void pktrt__tile_render_pixels(pktrt__tile *tile, const uint32_t *x, const uint32_t *y, uint32_t pixels,
                                      uint32_t room) {
  const uint32_t samples = tile->render->samples;
  uint32_t n = 0;
  memset(tile->sum, 0, sizeof tile->sum);
  if (tile->render->desc->cost) memset(tile->cost, 0, sizeof tile->cost);
  if (tile->render->choose) pktrt__split_begin(tile, x, y, pixels);
  if (pktrt__aov_wanted(tile->render)) {
    memset(tile->hit_count, 0, sizeof tile->hit_count), memset(tile->depth, 0, sizeof tile->depth);
    memset(tile->normal, 0, sizeof tile->normal), memset(tile->albedo, 0, sizeof tile->albedo);
  }
  for (uint32_t p = 0; p < pixels; p++)
    for (uint32_t s = 0; s < samples; s++) {
      tile->x[n] = x[p], tile->y[n] = y[p], tile->sample[n] = s;
      tile->pixel[n++] = p;
      if (n == room || (p + 1 == pixels && s + 1 == samples)) {
        pktrt__tile_run_wave(tile, n);
        n = 0;
      }
    }
  if (!tile->failed) pktrt__tile_write_pixels(tile, x, y, pixels);
}

/* Renders a block of edge x edge pixels by cells of cell x cell pixels, whose samples all follow each other, so that
   they fall into one packet. `room` rays go into a wave. */
static void pktrt__tile_render_block(pktrt__tile *tile, const uint32_t area[4], uint32_t bx, uint32_t by, uint32_t edge,
                                     uint32_t cell, uint32_t room) {
  uint32_t x[PKTRT__BATCH], y[PKTRT__BATCH], pixels = 0;
  for (uint32_t cy = 0; cy < edge; cy += cell)
    for (uint32_t cx = 0; cx < edge; cx += cell)
      for (uint32_t i = 0; i < cell * cell; i++) {
        const uint32_t px = bx + cx + tile->across[i], py = by + cy + tile->down[i];
        if (px >= area[2] || py >= area[3]) continue;
        x[pixels] = px, y[pixels++] = py;
      }
  pktrt__tile_render_pixels(tile, x, y, pixels, room);
}
/* Returns the largest power of two whose square, times the samples of a pixel, does not exceed a number of rays. */
static uint32_t pktrt__tile_pixel_edge(uint32_t rays, uint32_t samples) {
  uint32_t edge = 1;
  while (4 * edge * edge * samples <= rays) edge *= 2;
  return edge;
}

static void pktrt__tile_free(pktrt__tile *tile) {
  const pktrt_scene_desc *d = &tile->render->scene->desc;
  for (uint32_t i = 0; i <= PKTRT_MAX_DEPTH; i++) {
    pktrt__mem_release(d, tile->reflected[i], 1, sizeof(pktrt__wave));
    pktrt__mem_release(d, tile->refracted[i], 1, sizeof(pktrt__wave));
  }
  pktrt__mem_release(d, tile->spare, 1, sizeof(pktrt__wave));
  pktrt__mem_release(d, tile->cuts, PKTRT__LIGHT_CUTS, sizeof *tile->cuts);
  pktrt__mem_release(d, tile, 1, sizeof *tile);
}
PKTRT__COLD pktrt__tile *pktrt__tile_make(const pktrt__render_state *render, struct pktrt__pass_rounds *rounds,
                                          pktrt_stats *stats) { /* NULL: out of memory */
  pktrt__tile *tile = PKTRT__CAST(pktrt__tile *, pktrt__mem_alloc(&render->scene->desc, 1, sizeof *tile));
  if (!tile) return NULL;
  tile->cuts = NULL;
  if (render->tree && render->desc->lights != PKTRT_LIGHTS_ALL) {
    tile->cuts =
        PKTRT__CAST(pktrt__light_cut *, pktrt__mem_alloc(&render->scene->desc, PKTRT__LIGHT_CUTS, sizeof *tile->cuts));
    for (uint32_t i = 0; tile->cuts && i < PKTRT__LIGHT_CUTS; i++) tile->cuts[i].cell[3] = -1;
    if (!tile->cuts) {
      pktrt__mem_release(&render->scene->desc, tile, 1, sizeof *tile);
      return NULL;
    }
  }
  memset(tile->reflected, 0, sizeof tile->reflected);
  memset(tile->refracted, 0, sizeof tile->refracted);
  tile->spare = NULL, tile->queue.n = 0, tile->failed = tile->stopped = tile->apart = false;
  tile->rounds = rounds, tile->shaded_packets = 0;
  memset(tile->queue.batch.tmin, 0, sizeof tile->queue.batch.tmin);
  tile->queue.batch.occluder_tree = tile->glass_batch.occluder_tree = NULL;
  for (uint32_t i = 0; i < PKTRT__BATCH; i++) tile->surfaces.number[i] = i;
  tile->render = render, tile->stats = stats;
  tile->across[0] = tile->down[0] = 0;
  for (uint32_t i = 1; i < PKTRT__BATCH; i++) { /* Morton's order: the bits of both by turns */
    tile->across[i] = (uint8_t)(tile->across[i / 4] * 2 + i % 2);
    tile->down[i] = (uint8_t)(tile->down[i / 4] * 2 + i / 2 % 2);
  }
  /* The fast path takes many packets at once, which keeps secondary packets full. If an assembly is asked for, and on
     the paper path, each packet spawns its rays by itself, as in the paper. */
  tile->large_waves = render->desc->path != PKTRT_PATH_PAPER && !render->desc->cost &&
                      render->desc->assembly == PKTRT_ASSEMBLY_RAY_TYPES;
  return tile;
}

/* Begins a pass. Returns how many rays go into a wave. Seeds of passes are multiples of 2^32 over the golden ratio, as
   far apart as can be: up to 65536 passes of a seed meet none of another seed within 29,000 of it. */
static uint32_t pktrt__tile_begin_pass(pktrt__tile *tile, uint32_t pass) {
  tile->pass = pass, tile->sampling = tile->render->sampling;
  tile->sampling.seed += pass * 0x9E3779B9u;
  return tile->large_waves ? (uint32_t)PKTRT__BATCH : tile->render->packet_size * tile->render->packet_size;
}

/* Renders a pass over pixels [area[0], area[2]) x [area[1], area[3]). */
static void pktrt__tile_render_area(pktrt__tile *tile, const uint32_t area[4], uint32_t pass) {
  const pktrt__render_state *render = tile->render;
  const uint32_t packet = render->packet_size * render->packet_size, room = pktrt__tile_begin_pass(tile, pass);
  const uint32_t edge = pktrt__tile_pixel_edge(room, render->samples),
                 cell = pktrt__tile_pixel_edge(packet, render->samples);
  for (uint32_t y = area[1]; y < area[3] && !tile->failed; y += edge)
    for (uint32_t x = area[0]; x < area[2] && !tile->failed; x += edge)
      pktrt__tile_render_block(tile, area, x, y, edge, cell, room);
}

/* >>passes: what several passes know of their error, and who gets the next one ------------------------------------- */

static void pktrt__pass_free(const pktrt_scene_desc *desc, pktrt__pass_sums *p) {
  const uint64_t pixels = (uint64_t)p->w * p->h;
  pktrt__mem_release(desc, p->sums, pixels, sizeof *p->sums);
  pktrt__mem_release(desc, p->aovs, pixels, sizeof *p->aovs);
  pktrt__mem_release(desc, p->cells, (uint64_t)p->cell_columns * p->cell_rows, sizeof *p->cells);
  pktrt__mem_release(desc, p->blocks, (uint64_t)p->columns * p->rows, sizeof *p->blocks);
}

/* Returns the pixels of a square of `edge` pixels, cut off at the right and lower edge. */
static void pktrt__pass_square(const pktrt__pass_sums *p, uint32_t edge, uint32_t column, uint32_t row,
                               uint32_t area[4]) {
  const uint32_t x = column * edge, y = row * edge;
  area[0] = x, area[1] = y, area[2] = p->w - x < edge ? p->w : x + edge, area[3] = p->h - y < edge ? p->h : y + edge;
}

/* Makes sums for pixels [area[0], area[2]) x [area[1], area[3]), if there may be several passes. */
static bool pktrt__pass_make(pktrt__render_state *render, const uint32_t area[4],
                             pktrt__pass_sums *p) { /* false: out of memory */
  const pktrt_scene_desc *desc = &render->scene->desc;
  memset(p, 0, sizeof *p);
  if (render->most_passes == 1) return true;
  p->x = area[0], p->y = area[1], p->w = area[2] - area[0], p->h = area[3] - area[1], p->samples = render->samples;
  p->columns = (p->w + PKTRT_ERROR_BLOCK - 1) / PKTRT_ERROR_BLOCK;
  p->rows = (p->h + PKTRT_ERROR_BLOCK - 1) / PKTRT_ERROR_BLOCK;
  p->cell_columns = (p->w + PKTRT__PASS_CELL - 1) / PKTRT__PASS_CELL;
  p->cell_rows = (p->h + PKTRT__PASS_CELL - 1) / PKTRT__PASS_CELL;
  const uint64_t pixels = (uint64_t)p->w * p->h, blocks = (uint64_t)p->columns * p->rows;
  const uint64_t cells = (uint64_t)p->cell_columns * p->cell_rows;
  const bool notes = pktrt__aov_wanted(render);
  p->sums = PKTRT__CAST(pktrt__pixel_sums *, pktrt__mem_alloc(desc, pixels, sizeof *p->sums));
  p->cells = PKTRT__CAST(pktrt__pass_cell *, pktrt__mem_alloc(desc, cells, sizeof *p->cells));
  p->blocks = PKTRT__CAST(pktrt__pass_block *, pktrt__mem_alloc(desc, blocks, sizeof *p->blocks));
  if (notes) p->aovs = PKTRT__CAST(pktrt__aov_sums *, pktrt__mem_alloc(desc, pixels, sizeof *p->aovs));
  if (!p->sums || !p->cells || !p->blocks || (notes && !p->aovs)) {
    pktrt__pass_free(desc, p);
    return false;
  }
  memset(p->sums, 0, (size_t)pixels * sizeof *p->sums);
  memset(p->cells, 0, (size_t)cells * sizeof *p->cells);
  for (uint64_t i = 0; i < cells; i++) {
    uint32_t part[4];
    pktrt__pass_square(p, PKTRT__PASS_CELL, (uint32_t)(i % p->cell_columns), (uint32_t)(i / p->cell_columns), part);
    p->cells[i].pixels = (part[2] - part[0]) * (part[3] - part[1]);
  }
  if (notes) memset(p->aovs, 0, (size_t)pixels * sizeof *p->aovs);
  render->passes = p;
  return true;
}

/* Returns sum |x_i - x|^2 of a pixel after n passes, see pktrt_error_measure; each is 1 / n. What rounding leaves of
   equal means counts as 0: two sums of n squares are each off by n 2^-53 of themselves at most. */
PKTRT__INLINE double pktrt__pass_spread(const pktrt__pixel_sums *s, double n, double each) {
  const double spread = s->squares - pktrt__dot(s->mean, s->mean) * each;
  return spread <= n * 4.5e-16 * s->squares ? 0 : spread;
}

static double pktrt__pass_squared_error(const pktrt__pixel_sums *s, double n) { /* V of pktrt_error_measure */
  return n < 2 ? INFINITY : pktrt__pass_spread(s, n, 1 / n) / (n * (n - 1));
}
/* Adds a cell's errors and means to those of its block, without pixels whose error is not finite. */
static void pktrt__pass_sum_cell(const pktrt__pass_sums *p, uint32_t column, uint32_t row, pktrt__pass_block *b) {
  pktrt__pass_cell *cell = &p->cells[(size_t)row * p->cell_columns + column];
  const double n = cell->done, each = 1 / n, part = n < 2 ? 0 : 1 / (n * (n - 1)),
               all = (double)PKTRT__PILOT * p->samples;
  double spread = 0, squares = 0, red = 0, green = 0, blue = 0, gain = 0, splits = 0;
  uint32_t area[4];
  pktrt__pass_square(p, PKTRT__PASS_CELL, column, row, area);
  for (uint32_t y = area[1]; y < area[3]; y++)
    for (const pktrt__pixel_sums *s = &p->sums[(size_t)y * p->w + area[0]], *end = s + (area[2] - area[0]); s < end;
         s++) {
      const double one = pktrt__pass_spread(s, n, each);
      gain += (double)s->gain, splits += (double)s->splits;
      if (n < 2 || !(one < INFINITY)) {
        b->unknown++;
        continue;
      }
      spread += one, squares += one * one, red += s->mean[0], green += s->mean[1], blue += s->mean[2];
    }
  squares *= part * part;
  cell->variance = spread * part * n;
  /* With S samples in each of P pilot passes, D is gain / (P S^2), and g splits / (P S) over the number of pixels. */
  cell->split = gain * (all * cell->pixels + splits) > cell->variance * splits * all * p->samples;
  b->pixels += cell->pixels, b->error[0] += spread * part, b->squares += squares;
  b->doubt += squares * 2 * n / (n + 1);
  b->mean[0] += red * each, b->mean[1] += green * each, b->mean[2] += blue * each;
}

PKTRT__COLD void pktrt__pass_sum_errors(void *arg, size_t row) { /* a row of blocks */
  pktrt__pass_sums *p = PKTRT__CAST(pktrt__pass_sums *, arg);
  const uint32_t each = PKTRT_ERROR_BLOCK / PKTRT__PASS_CELL, first = (uint32_t)row * each;
  memset(&p->blocks[row * p->columns], 0, p->columns * sizeof *p->blocks);
  for (uint32_t y = first; y < first + each && y < p->cell_rows; y++)
    for (uint32_t x = 0; x < p->cell_columns; x++)
      pktrt__pass_sum_cell(p, x, y, &p->blocks[row * p->columns + x / each]);
}

/* Writes how far an estimate can be believed: `error`, `squares` and `doubt` are sums over `known` pixels. Returns the
   factor that an interval goes up and down from its root. WHY 2 / (1 + 1 / n): of grey normal scatter, V is off by
   2 V^2 / (n - 1), the true error by 2 V^2, and V^2 is too large by the factor 1 + 2 / (n - 1). Scatter with rare
   large values is off by as much, as it counts them in both. WHY 8 and an eighth: where rare light is most of the
   error, fewer passes have often seen none of it, and would not know. */
static double pktrt__pass_believe(pktrt_report *r, int measure, const double sums[3], double known, double passes) {
  const double error = sums[0], squares = sums[1], off = error > 0 ? sqrt(sums[2]) / error : 0;
  r->effective_pixels[measure] = squares > 0 ? error * error / squares : 0;
  r->unreliable[measure] = !(error < INFINITY) || !(off <= 0.25) || !(known > 0) ||
                           (error > 0 && passes < 8 && r->effective_pixels[measure] < known / 8);
  return off + sqrt(1 + off * off);
}

/* Writes the error of the whole picture, as far as known, to the report; `passes`: a mean over pixels. */
static void pktrt__pass_estimate(const pktrt__render_state *render, double passes, pktrt_report *r) {
  pktrt__pass_sums *p = render->passes;
  const uint64_t blocks = (uint64_t)p->columns * p->rows;
  double sums[2][3] = {{0, 0, 0}, {0, 0, 0}}, mean[3] = {0, 0, 0}, known = 0; /* of V, V^2 and doubt */
  r->unknown = 0;
  pktrt__parallel_for(&render->scene->desc, p->rows, pktrt__pass_sum_errors, p);
  for (uint64_t i = 0; i < blocks; i++) {
    const pktrt__pass_block *b = &p->blocks[i];
    known += b->pixels - b->unknown, r->unknown += b->unknown;
    for (int a = 0; a < 3; a++) mean[a] += b->mean[a];
  }
  const double n = pktrt__max(1, known), least = 0.01 * pktrt__dot(mean, mean) / (n * n);
  for (uint64_t i = 0; i < blocks; i++) {
    pktrt__pass_block *b = &p->blocks[i];
    const double pixels = pktrt__max(1, b->pixels - b->unknown);
    const double against = pktrt__dot(b->mean, b->mean) / (pixels * pixels) + least;
    b->weight = against > 0 ? 1 / against : 0; /* negative radiance may make that 0 */
    b->error[1] = b->error[0] * b->weight;
    for (int k = 0; k < 2; k++) {
      const double square = k ? b->weight * b->weight : 1;
      sums[k][0] += b->error[k], sums[k][1] += b->squares * square, sums[k][2] += b->doubt * square;
    }
  }
  r->rmse = known > 0 ? sqrt(sums[0][0] / (3 * known)) : INFINITY;
  r->relative_mse = known > 0 ? sums[1][0] / known : INFINITY;
  const double factor = pktrt__pass_believe(r, 0, sums[0], known, passes);
  const double other = pktrt__pass_believe(r, 1, sums[1], known, passes);
  r->rmse_low = r->rmse / factor, r->rmse_high = r->rmse * factor;
  r->relative_mse_high = r->relative_mse * other * other;
}

/* --- adaptive passes ---

   A cell of c pixels whose passes have variance s each (V n, summed over its pixels) contributes s / R after R passes,
   which cost c R. For a given cost the sum of errors is least if R is in proportion to q = sqrt(s / c), so that cells
   get more passes where these help more: R = max(done, scale q), for what is done is done. The scale that spends a
   budget, or reaches an error, follows from the cells whose R exceeds `done`: found by removing the others. */

/* Returns s / c of a cell, a quarter of it that of the 3 x 3 cells around. WHY: two passes may miss what is rare. */
static double pktrt__pass_cell_variance(const pktrt__pass_sums *p, uint32_t column, uint32_t row) {
  double sum = 0, pixels = 0;
  for (uint32_t y = row ? row - 1 : 0; y <= row + 1 && y < p->cell_rows; y++)
    for (uint32_t x = column ? column - 1 : 0; x <= column + 1 && x < p->cell_columns; x++) {
      const pktrt__pass_cell *cell = &p->cells[(size_t)y * p->cell_columns + x];
      sum += cell->variance, pixels += cell->pixels;
    }
  const pktrt__pass_cell *cell = &p->cells[(size_t)row * p->cell_columns + column];
  return 0.75 * cell->variance / cell->pixels + 0.25 * sum / pixels;
}

/* Returns the scale that spends `budget` pixel passes in all, or with budget 0 leaves `error`; 0 if that is reached. */
static double pktrt__pass_scale(const pktrt__pass_sums *p, double budget, double error) {
  const uint64_t cells = (uint64_t)p->cell_columns * p->cell_rows;
  double scale = INFINITY;
  for (;;) {
    double spent = 0, left = 0, open = 0;
    for (uint64_t i = 0; i < cells; i++) {
      const pktrt__pass_cell *cell = &p->cells[i];
      const bool closed = scale * cell->want <= cell->done || cell->want <= 0; /* `want` holds q */
      if (closed) {
        spent += (double)cell->pixels * cell->done;
        left += cell->want * cell->want * cell->pixels / cell->done;
      } else open += cell->want * cell->pixels;
    }
    const double by_error = error > left ? open / (error - left) : INFINITY;
    const double next = open <= 0 ? 0 : budget > 0 ? (budget - spent) / open : by_error;
    if (!(next < scale)) return next < INFINITY ? next : scale;
    scale = next;
  }
}

/* Sets `want` of all cells: q, but at least a quarter of the mean, for error that has not been seen may yet come. */
static void pktrt__pass_ask_cells(pktrt__pass_sums *p, bool relative) {
  const uint64_t cells = (uint64_t)p->cell_columns * p->cell_rows;
  const uint32_t each = PKTRT_ERROR_BLOCK / PKTRT__PASS_CELL;
  double sum = 0;
  for (uint32_t row = 0; relative && row < p->cell_rows; row++)
    for (uint32_t column = 0; column < p->cell_columns; column++)
      p->cells[(size_t)row * p->cell_columns + column].variance *=
          p->blocks[(size_t)(row / each) * p->columns + column / each].weight;
  for (uint32_t row = 0; row < p->cell_rows; row++)
    for (uint32_t column = 0; column < p->cell_columns; column++) {
      pktrt__pass_cell *cell = &p->cells[(size_t)row * p->cell_columns + column];
      cell->want = sqrt(pktrt__pass_cell_variance(p, column, row));
      sum += cell->want;
    }
  const double least = sum > 0 ? sum / (4 * (double)cells) : 1;
  for (uint64_t i = 0; i < cells; i++)
    if (!(p->cells[i].want > least && p->cells[i].want < INFINITY)) p->cells[i].want = least;
}

/* Shares out the next round's passes: up to `budget` pixel passes with the `spent` before, fewer if that reaches the
   target, but some, since wants are no exact forecast. Cells want fractions of passes; what one lacks to a whole pass
   goes to the next. If none gets any, the one that wants most gets one: every round does something, so rounds end. */
static void pktrt__pass_share_out(const pktrt__render_state *render, double spent, double budget, double target) {
  pktrt__pass_sums *p = render->passes;
  pktrt__pass_cell *first = NULL;
  const uint32_t most = UINT32_MAX / render->samples;
  double carry = 0.5, given = 0;
  pktrt__pass_ask_cells(p, render->desc->measure == PKTRT_ERROR_RELATIVE);
  double scale = pktrt__pass_scale(p, budget, 0);
  if (target > 0) {
    const double least = pktrt__pass_scale(p, pktrt__min(budget, 1.03 * spent), 0);
    scale = pktrt__min(scale, pktrt__max(least, pktrt__pass_scale(p, 0, target)));
  }
  for (uint64_t i = 0; i < (uint64_t)p->cell_columns * p->cell_rows; i++) {
    pktrt__pass_cell *cell = &p->cells[i];
    const double more = scale * cell->want - cell->done, room = most - cell->done;
    carry += more > 0 ? pktrt__min(more, room) : 0;
    cell->more = (uint32_t)pktrt__min(carry, room);
    carry -= cell->more, given += cell->more;
    if (room > 0 && (!first || cell->want * first->done > first->want * cell->done)) first = cell;
  }
  if (given <= 0 && first) first->more = 1;
}

/* --- rounds --- */

#if defined(__GNUC__) && !defined(__TINYC__)
PKTRT__INLINE uint32_t pktrt__atomic_increment(uint32_t *x) { return __atomic_add_fetch(x, 1, __ATOMIC_RELAXED); }
PKTRT__INLINE uint32_t pktrt__atomic_load(uint32_t *x) { return __atomic_load_n(x, __ATOMIC_RELAXED); }
#else /* without atomics the progress told may lag; the picture is the same */
PKTRT__INLINE uint32_t pktrt__atomic_increment(uint32_t *x) { return ++*x; }
PKTRT__INLINE uint32_t pktrt__atomic_load(uint32_t *x) { return *x; }
#endif

typedef struct pktrt__pass_rounds {
  const pktrt__render_state *render;
  pktrt_stats *stats;               /* one for each tile, or NULL */
  uint32_t columns, count;          /* of tiles */
  uint32_t done, cancelled, failed; /* shared by the workers */
  uint32_t late;                    /* cancelled at the last tile: counts only if another round would follow */
  float from, to;                   /* progress before and after this round, as far as it can be told */
  double clock, spent;              /* when the last round ended; passes so far, a mean over pixels */
  uint32_t alike;                   /* passes of each block in this round; 0 if they differ */
  bool timed, watched;              /* whether rounds are timed; whether errors are estimated after each */
  pktrt_report report;
} pktrt__pass_rounds;

#if defined(__unix__) || defined(__APPLE__)
#include <sys/time.h>
static double pktrt__clock(void) { /* the POSIX clock that strict ISO C does not hide */
  struct timeval now;
  gettimeofday(&now, NULL);
  return (double)now.tv_sec + 1e-6 * (double)now.tv_usec;
}
#else
#include <time.h>
static double pktrt__clock(void) { return (double)clock() / CLOCKS_PER_SEC; } /* Windows: since the start */
#endif

static double pktrt__pass_now(const pktrt_render_desc *d) { return d->seconds ? d->seconds(d->user) : pktrt__clock(); }

/* Returns the passes of the next round, a mean over pixels: one, or if adaptive, two and then half of what has been
   done; no more than are left, or fit into the time if they take as long as those before. 0: time is up. */
static double pktrt__pass_next_round(const pktrt__pass_rounds *t) {
  const pktrt_render_desc *d = t->render->desc;
  const double spent = t->spent, left = t->render->most_passes - spent;
  double next = !d->adaptive ? 1 : spent > 0 ? pktrt__max(1, 0.5 * spent) : (double)PKTRT__PILOT;
  if (d->time_budget > 0 && spent > 0 && t->report.seconds > 0) {
    const double fit = (d->time_budget - t->report.seconds) / t->report.seconds * spent;
    if (!(fit >= (d->adaptive ? 0.1 * spent : 1))) return 0;
    next = pktrt__min(next, fit);
  }
  return pktrt__min(next, left);
}

/* Tells whether the estimate may end the render as it is, without regard to its interval. */
static bool pktrt__pass_believed(const pktrt__pass_rounds *t) {
  return t->render->desc->trust_estimates || !t->report.unreliable[t->render->desc->measure == PKTRT_ERROR_RELATIVE];
}

/* Plans how many passes each cell gets in the next round: all the same while nothing is known. */
static void pktrt__pass_plan_round(pktrt__pass_rounds *t, double next) {
  const pktrt_render_desc *d = t->render->desc;
  const pktrt__pass_sums *p = t->render->passes;
  const double pixels = (double)d->width * d->height, known = pixels - (double)t->report.unknown;
  const double target = pktrt__pass_believed(t) ? (double)d->target_error : 0;
  t->alike = d->adaptive && t->spent > 0 ? 0 : (uint32_t)next;
  for (uint64_t i = 0; p && i < (uint64_t)p->cell_columns * p->cell_rows; i++) p->cells[i].more = t->alike;
  if (t->alike) return;
  const double error = d->measure == PKTRT_ERROR_RELATIVE ? target : 3 * target * target;
  pktrt__pass_share_out(t->render, t->spent * pixels, (t->spent + next) * pixels, 0.98 * error * known);
}

/* Appends the pixels of a cell within an area, in the order of the tile's curve. Returns how many there are now. */
static uint32_t pktrt__pass_add_pixels(const pktrt__tile *tile, uint32_t left, uint32_t top, const uint32_t area[4],
                                       uint32_t *x, uint32_t *y, uint32_t pixels) {
  for (uint32_t i = 0; i < PKTRT__PASS_CELL * PKTRT__PASS_CELL; i++) {
    const uint32_t px = left + tile->across[i], py = top + tile->down[i];
    if (px >= area[0] && px < area[2] && py >= area[1] && py < area[3]) x[pixels] = px, y[pixels++] = py;
  }
  return pixels;
}

/* Renders one pass over those cells of a square from (left, top) on that get it in this round. Cells next to each other
   on the tile's curve share waves. Returns the least number of a later pass, UINT32_MAX: none. */
static uint32_t pktrt__pass_render_cells(const pktrt__pass_sums *p, pktrt__tile *tile, uint32_t left, uint32_t top,
                                         const uint32_t area[4], uint32_t pass) {
  const uint32_t room = pktrt__tile_begin_pass(tile, pass), edge = PKTRT__PASS_CELL, samples = tile->render->samples;
  uint32_t x[PKTRT__BATCH], y[PKTRT__BATCH], pixels = 0, later = UINT32_MAX;
  for (uint32_t i = 0; i < PKTRT__BATCH && !tile->failed; i++) {
    const uint32_t cx = left + tile->across[i] * edge, cy = top + tile->down[i] * edge;
    if (cx >= area[2] || cy >= area[3]) continue;
    const pktrt__pass_cell *cell = &p->cells[(size_t)(cy / edge) * p->cell_columns + cx / edge];
    const uint32_t end = cell->done + cell->more, next = cell->done > pass ? cell->done : pass + 1;
    if (next < end && next < later) later = next;
    if (cell->done > pass || pass >= end) continue;
    pixels = pktrt__pass_add_pixels(tile, cx, cy, area, x, y, pixels);
    if (pixels + edge * edge <= PKTRT__BATCH && (pixels + edge * edge) * samples <= room) continue;
    pktrt__tile_render_pixels(tile, x, y, pixels, room);
    pixels = 0;
  }
  if (pixels && !tile->failed) pktrt__tile_render_pixels(tile, x, y, pixels, room);
  return later;
}

/* Renders the passes that this round gives to the cells of an area, square by square. False: out of memory. */
static bool pktrt__pass_render_adaptive(pktrt__pass_rounds *t, const uint32_t area[4], pktrt_stats *stats) {
  const pktrt__pass_sums *p = t->render->passes;
  const uint32_t edge = PKTRT_ERROR_BLOCK * PKTRT__PASS_CELL; /* PKTRT__BATCH cells */
  pktrt__tile *tile = pktrt__tile_make(t->render, t, stats);
  if (!tile) return false;
  for (uint32_t y = area[1] / edge * edge; y < area[3] && !tile->failed; y += edge)
    for (uint32_t x = area[0] / edge * edge; x < area[2] && !tile->failed; x += edge)
      for (uint32_t pass = 0; pass < UINT32_MAX && !tile->failed && !pktrt__atomic_load(&t->cancelled);)
        pass = pktrt__pass_render_cells(p, tile, x, y, area, pass);
  const bool ok = !tile->failed || tile->stopped;
  pktrt__tile_free(tile);
  return ok;
}

/* Renders `passes` more passes over an area whose blocks all get the same. False: out of memory. */
static bool pktrt__pass_render_uniform(const pktrt__render_state *render, pktrt__pass_rounds *t, const uint32_t area[4],
                                       pktrt_stats *stats, uint32_t before, uint32_t passes) {
  pktrt__tile *tile = pktrt__tile_make(render, t, stats);
  if (!tile) return false;
  for (uint32_t k = 0; k < passes; k++) pktrt__tile_render_area(tile, area, before + k);
  const bool ok = !tile->failed || tile->stopped;
  pktrt__tile_free(tile);
  return ok;
}

/* Tells the progress hook that `done` tiles of the round are done. Returns its answer. */
static bool pktrt__pass_tell_progress(const pktrt__pass_rounds *t, uint32_t done) {
  const pktrt_render_desc *d = t->render->desc;
  const float part = (float)done / (float)t->count, all = t->from + (t->to - t->from) * part;
  return !d->progress || d->progress(d->user, part < 1 ? all : t->to);
}

static bool pktrt__pass_goes_on(pktrt__pass_rounds *t) {
  if (pktrt__atomic_load(&t->cancelled)) return false;
  const bool on = pktrt__pass_tell_progress(t, pktrt__atomic_load(&t->done));
  if (!on) (void)pktrt__atomic_increment(&t->cancelled);
  return on;
}

static void pktrt__pass_run_tile(void *arg, size_t i) {
  pktrt__pass_rounds *t = PKTRT__CAST(pktrt__pass_rounds *, arg);
  const pktrt_render_desc *d = t->render->desc;
  if (pktrt__atomic_load(&t->cancelled) || pktrt__atomic_load(&t->failed)) return;
  const uint32_t size = t->render->tile_size, x = (uint32_t)i % t->columns * size, y = (uint32_t)i / t->columns * size;
  const uint32_t x1 = d->width - x < size ? d->width : x + size, y1 = d->height - y < size ? d->height : y + size;
  const uint32_t area[4] = {x, y, x1, y1};
  pktrt_stats *stats = t->stats ? &t->stats[i] : NULL;
  const bool ok = t->alike ? pktrt__pass_render_uniform(t->render, t, area, stats, (uint32_t)t->spent, t->alike)
                           : pktrt__pass_render_adaptive(t, area, stats);
  if (!ok) (void)pktrt__atomic_increment(&t->failed);
  if (pktrt__atomic_load(&t->cancelled)) return; /* the tile may lack pixels or passes */
  const uint32_t done = pktrt__atomic_increment(&t->done);
  if (!pktrt__pass_tell_progress(t, done)) (void)pktrt__atomic_increment(done < t->count ? &t->cancelled : &t->late);
}

/* Updates cells and report after a round. */
static void pktrt__pass_end_round(pktrt__pass_rounds *t) {
  const pktrt__render_state *render = t->render;
  const pktrt_render_desc *d = render->desc;
  pktrt__pass_sums *p = render->passes;
  pktrt_report *r = &t->report;
  uint32_t least = UINT32_MAX, most = 0;
  double sum = 0;
  for (uint64_t i = 0; p && i < (uint64_t)p->cell_columns * p->cell_rows; i++) {
    pktrt__pass_cell *cell = &p->cells[i];
    cell->done += cell->more;
    least = cell->done < least ? cell->done : least, most = cell->done > most ? cell->done : most;
    sum += (double)cell->done * cell->pixels;
  }
  t->spent = p ? sum / ((double)d->width * d->height) : 1;
  r->rounds++;
  r->samples_min = (p ? least : 1) * render->samples, r->samples_max = (p ? most : 1) * render->samples;
  r->samples_mean = t->spent * render->samples;
  if (!t->timed) return;
  const double now = pktrt__pass_now(d); /* time does not count when a clock is set back */
  if (now > t->clock) r->seconds += now - t->clock;
  t->clock = now;
}

/* Decides after a round by which rule, if any, the render stops. */
static pktrt_stop pktrt__pass_judge(const pktrt__pass_rounds *t) {
  const pktrt_render_desc *d = t->render->desc;
  const pktrt_report *r = &t->report;
  const bool relative = d->measure == PKTRT_ERROR_RELATIVE, believed = pktrt__pass_believed(t);
  const double high = t->spent < 8 ? INFINITY : relative ? r->relative_mse_high : r->rmse_high;
  const double error = !believed ? high : relative ? r->relative_mse : r->rmse;
  const double cell = PKTRT__PASS_CELL * PKTRT__PASS_CELL / ((double)d->width * d->height);
  const double rest = d->adaptive ? pktrt__max(0.1, 0.5 * cell) : 0.5; /* cells get whole passes */
  if (d->target_error > 0 && error <= (double)d->target_error) return r->unknown ? PKTRT_STOP_PASSES : PKTRT_STOP_ERROR;
  if (d->target_error > 0 && t->spent >= 2 && r->rmse == INFINITY) return PKTRT_STOP_PASSES; /* never to be known */
  if (t->spent > t->render->most_passes - pktrt__min(rest, 0.5)) return PKTRT_STOP_PASSES;
  return d->time_budget > 0 && pktrt__pass_next_round(t) <= 0 ? PKTRT_STOP_TIME : PKTRT_STOP_NOT_YET;
}

/* Estimates how much of the work will be done after `next` more passes, by the rule that seems nearest. */
static float pktrt__pass_progress(const pktrt__pass_rounds *t, double next) {
  const pktrt_render_desc *d = t->render->desc;
  const pktrt_report *r = &t->report;
  double part = (t->spent + next) / t->render->most_passes;
  if (t->spent > 0 && d->time_budget > 0)
    part = pktrt__max(part, r->seconds / d->time_budget * (t->spent + next) / t->spent);
  if (t->spent > 0 && d->target_error > 0 && r->rmse < INFINITY) {
    const double target = (double)d->target_error, root = target / r->rmse;
    const double wanted = d->measure == PKTRT_ERROR_RELATIVE ? target / r->relative_mse : root * root; /* share done */
    part = pktrt__max(part, wanted * (t->spent + next) / t->spent);
  }
  return part < 1 ? (float)part : 1.0f;
}

static void pktrt__pass_run(pktrt__pass_rounds *t) {
  const pktrt_render_desc *d = t->render->desc;
  pktrt_report *r = &t->report;
  while (!r->stop) {
    const double next = pktrt__pass_next_round(t);
    pktrt__pass_plan_round(t, next);
    t->done = 0, t->from = t->to, t->to = pktrt__maxf(t->from, pktrt__pass_progress(t, next));
    pktrt__parallel_for(&t->render->scene->desc, t->count, pktrt__pass_run_tile, t);
    if (t->cancelled || t->failed) {
      r->stop = PKTRT_STOP_CANCELLED;
      return;
    }
    pktrt__pass_end_round(t);
    if (t->watched && t->render->passes) pktrt__pass_estimate(t->render, t->spent, r);
    r->stop = pktrt__pass_judge(t);
    if (t->late && !r->stop) t->cancelled = 1, r->stop = PKTRT_STOP_CANCELLED;
    if (d->pass && !d->pass(d->user, r) && !r->stop) r->stop = PKTRT_STOP_ASKED;
  }
}

/* Writes the buffers of errors when all is done. */
static void pktrt__pass_write_errors(const pktrt__render_state *render) {
  const pktrt_render_desc *d = render->desc;
  const pktrt__pass_sums *p = render->passes;
  const uint32_t b = PKTRT_ERROR_BLOCK, columns = (d->width + b - 1) / b;
  for (uint32_t y = 0; y < d->height; y++)
    for (uint32_t x = 0; x < d->width; x++) {
      const size_t at = (size_t)y * d->width + x, block = (size_t)(y / b) * columns + x / b;
      const size_t cell = p ? (size_t)(y / PKTRT__PASS_CELL) * p->cell_columns + x / PKTRT__PASS_CELL : 0;
      const double known = p ? p->blocks[block].pixels - p->blocks[block].unknown : 0;
      if (d->pixel_error)
        d->pixel_error[at] =
            p ? pktrt__to_float(sqrt(pktrt__pass_squared_error(&p->sums[at], p->cells[cell].done) / 3)) : INFINITY;
      if (d->block_error && x % b == 0 && y % b == 0)
        d->block_error[block] = known > 0 ? pktrt__to_float(sqrt(p->blocks[block].error[0] / (3 * known))) : INFINITY;
    }
}

/* >>rendering ------------------------------------------------------------------------------------------------------ */

/* --- warnings of likely mistakes that show in the picture only --- */

static bool pktrt__any_positive(const float v[3]) { return v[0] > 0 || v[1] > 0 || v[2] > 0; }

static bool pktrt__warn_light_shines(const pktrt_render_desc *d, const pktrt__light_data *light, const pktrt_light *l) {
  if (l->kind == PKTRT_LIGHT_ENVIRONMENT && !d->environment && !pktrt__any_positive(d->background)) return false;
  return light->strength > 0;
}

/* Tells whether there is no light but a mesh that needs some: no emission, no shader, not only mirror or glass. */
PKTRT__COLD bool pktrt__warn_is_dark(const pktrt__render_state *render) {
  const pktrt_scene *s = render->scene;
  bool dark = false, lit = pktrt__any_positive(render->desc->ambient);
  for (uint32_t i = 0; i < s->light_count; i++)
    lit = lit || pktrt__warn_light_shines(render->desc, &render->lights[i], &s->lights[i]);
  for (uint32_t i = 0; !lit && i < s->committed_meshes; i++) {
    const pktrt_material *mat = pktrt__material_of(s, s->meshes[i].material);
    const bool shows = render->follow && mat->specular != PKTRT_SPECULAR_NONE && !pktrt__any_positive(mat->albedo);
    if (!s->meshes[i].triangle_count || mat->shader || pktrt__any_positive(mat->emission) || shows) continue;
    dark = dark || mat->texture || pktrt__any_positive(mat->albedo);
  }
  return dark;
}

PKTRT__COLD void pktrt__warn_of_mode(const pktrt_scene *s, const pktrt__render_state *render) {
  static const char *const modes[] = {"PKTRT_MODE_RCS", "PKTRT_MODE_WRT", "PKTRT_MODE_DRT"};
  const pktrt_render_desc *d = render->desc;
  const uint32_t lens = PKTRT_FEATURE_LENS | PKTRT_FEATURE_SHUTTER;
  const uint32_t shown = d->mode == PKTRT_MODE_DRT   ? ~0u
                         : d->mode == PKTRT_MODE_WRT ? ~lens
                                                     : ~(lens | PKTRT__SPECULAR | PKTRT_FEATURE_GLOSS);
  const uint32_t ignored = pktrt__feature_of_render(s, d) & ~shown;
  char text[256];
  int n = snprintf(text, sizeof text, "render: %s takes no notice of", modes[d->mode]);
  const char *between = " ";
  for (uint32_t bit = 1; ignored && bit <= PKTRT_FEATURE_SHUTTER; bit *= 2) {
    if (!(ignored & bit)) continue;
    n += snprintf(text + n, sizeof text - (size_t)n, "%s%s", between, pktrt_feature_string((pktrt_feature)bit));
    between = ", ";
  }
  if (ignored) pktrt__log_sentence(s, 0, text);
}

PKTRT__COLD void pktrt__warn_of_changes(const pktrt_scene *s) {
  char text[160];
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    if (m->free || (m->committed && !m->dirty && !m->dirty_normals && !m->gone && m->hide == m->hidden)) continue;
    (void)snprintf(text, sizeof text, "render: mesh %u %s since the last commit, which the picture does not show",
                   (unsigned)i,
                   m->gone        ? "was removed"
                   : m->committed ? "was changed"
                                  : "was added");
    pktrt__log_sentence(s, 0, text);
    return;
  }
}

/* Logs all warnings. The render's lights must have been made. */
PKTRT__COLD void pktrt__warn_all(const pktrt_scene *s, const pktrt__render_state *render) {
  if (!s->desc.log) return;
  pktrt__warn_of_mode(s, render), pktrt__warn_of_changes(s);
  if (pktrt__warn_is_dark(render))
    pktrt__log_sentence(s, 0, "render: there is no light and no ambient: what does not shine by itself is black");
}

/* Sets what is known before the first round. */
static void pktrt__pass_start(const pktrt__render_state *render, pktrt__pass_rounds *t) {
  memset(t, 0, sizeof *t);
  t->report.rmse = t->report.relative_mse = t->report.rmse_high = t->report.relative_mse_high = INFINITY;
  t->report.unreliable[0] = t->report.unreliable[1] = true;
  t->render = render;
}

/* Prepares everything that the first round needs. */
static pktrt_status pktrt__pass_begin(pktrt_scene *s, pktrt__render_state *render, pktrt__pass_sums *passes,
                                      pktrt__pass_rounds *t) {
  const pktrt_render_desc *d = render->desc;
  const uint32_t area[4] = {0, 0, d->width, d->height};
  pktrt__pass_start(render, t);
  t->columns = (d->width + render->tile_size - 1) / render->tile_size;
  const uint64_t count = (uint64_t)t->columns * ((d->height + render->tile_size - 1) / render->tile_size);
  if (count > INT32_MAX)
    return pktrt__fail(s, PKTRT_LIMIT, "render: %llu tiles are too many", (unsigned long long)count);
  t->count = (uint32_t)count;
  t->timed = d->time_budget > 0 || d->report || d->pass;
  t->watched = d->target_error > 0 || d->adaptive || d->pass;
  t->clock = t->timed ? pktrt__pass_now(d) : 0;
  if (d->stats) {
    t->stats = PKTRT__CAST(pktrt_stats *, pktrt__mem_alloc(&s->desc, count, sizeof *t->stats));
    if (!t->stats)
      return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "render: no memory for the statistics of %u tiles",
                         (unsigned)t->count);
    memset(t->stats, 0, (size_t)count * sizeof *t->stats);
  }
  if (!pktrt__pass_make(render, area, passes))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "render: no memory for the sums of %u x %u pixels", (unsigned)d->width,
                       (unsigned)d->height);
  if (!pktrt__render_prepare(render, (uint64_t)d->width * d->height))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "render: no memory for lights and glass");
  return PKTRT_OK;
}

static pktrt_status pktrt__pass_end(pktrt_scene *s, pktrt__render_state *render, pktrt__pass_rounds *t) {
  const pktrt_render_desc *d = render->desc;
  for (uint32_t i = 0; d->stats && i < t->count; i++) pktrt__stats_add(d->stats, &t->stats[i]);
  if (t->failed) return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "render: no memory for the rays of a tile");
  if (t->cancelled) return pktrt__fail(s, PKTRT_CANCELLED, "render: the progress hook asked to stop");
  if (render->passes && !d->pass && (d->report || d->pixel_error || d->block_error))
    pktrt__pass_estimate(render, t->spent, &t->report);
  if (d->pixel_error || d->block_error) pktrt__pass_write_errors(render);
  return PKTRT_OK;
}

PKTRT_DEF pktrt_status pktrt_render(pktrt_scene *s, const pktrt_render_desc *d) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  pktrt__render_state render;
  pktrt__pass_sums passes;
  pktrt__pass_rounds t;
  pktrt__refusal why;
  if (!pktrt__render_check(s, d, &render, &why)) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "render: %s", why.text);
  if (pktrt__render_is_uncommitted(s))
    return pktrt__fail(s, PKTRT_NOT_COMMITTED, "render: %u meshes were added, none was committed",
                       (unsigned)s->mesh_count);
  pktrt_status status = pktrt__pass_begin(s, &render, &passes, &t);
  if (status == PKTRT_OK) {
    pktrt__warn_all(s, &render);
    pktrt__pass_run(&t);
    status = pktrt__pass_end(s, &render, &t);
    pktrt__render_unprepare(&render);
  }
  if (d->report) *d->report = t.report;
  if (render.passes) pktrt__pass_free(&s->desc, &passes);
  pktrt__mem_release(&s->desc, t.stats, t.count, sizeof *t.stats);
  return status;
}

PKTRT_DEF pktrt_status pktrt_prepare_environment(pktrt_scene *s, const pktrt_render_desc *d) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  if (!d) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "environment: the description is NULL");
  pktrt__environment *made = NULL;
  if (d->environment && !(made = pktrt__environment_make(&s->desc, d, 512)))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "environment: no memory for its table");
  pktrt__environment_free(&s->desc, s->environment);
  s->environment = made;
  return PKTRT_OK;
}

static bool pktrt__pass_is_within(const pktrt_render_desc *d, uint32_t x, uint32_t y, uint32_t w, uint32_t h) {
  return x <= d->width && y <= d->height && w <= d->width - x && h <= d->height - y;
}

/* Renders passes [first, first + count) of an area. Where `means` is given, one pass's go there. */
static pktrt_status pktrt__pass_render_area(pktrt__render_state *render, const uint32_t area[4], uint32_t first,
                                            uint32_t count, double *means) {
  const pktrt_scene *s = render->scene;
  const uint64_t pixels = (uint64_t)(area[2] - area[0]) * (area[3] - area[1]);
  pktrt__pass_sums passes;
  if (pktrt__render_is_uncommitted(s)) return PKTRT_NOT_COMMITTED;
  if (!pixels) return PKTRT_OK;
  if (!pktrt__render_prepare(render, pixels)) return PKTRT_OUT_OF_MEMORY;
  const bool ok = pktrt__pass_make(render, area, &passes) &&
                  pktrt__pass_render_uniform(render, NULL, area, render->desc->stats, first, count);
  for (size_t i = 0; ok && means && i < pixels; i++) memcpy(means + 3 * i, passes.sums[i].mean, 3 * sizeof *means);
  if (render->passes) pktrt__pass_free(&s->desc, &passes);
  pktrt__render_unprepare(render);
  return ok ? PKTRT_OK : PKTRT_OUT_OF_MEMORY;
}

PKTRT_DEF pktrt_status pktrt_render_tile(const pktrt_scene *s, const pktrt_render_desc *d, uint32_t x, uint32_t y,
                                         uint32_t w, uint32_t h) {
  pktrt__render_state render;
  pktrt__refusal why;
  if (!s || !pktrt__render_check(s, d, &render, &why)) return PKTRT_INVALID_ARGUMENT;
  if (!pktrt__pass_is_within(d, x, y, w, h) || (render.most_passes > 1 && !d->passes)) return PKTRT_INVALID_ARGUMENT;
  if (d->adaptive || d->pass || d->report || d->pixel_error || d->block_error || d->target_error > 0 ||
      d->time_budget > 0)
    return PKTRT_INVALID_ARGUMENT;
  const uint32_t area[4] = {x, y, x + w, y + h};
  return pktrt__pass_render_area(&render, area, 0, render.most_passes, NULL);
}

/* --- passes made in several places --- */

/* Tells whether a pass over some pixels is all that they need from this one place. */
static bool pktrt__pass_is_separate(const pktrt_render_desc *d) {
  return !d->adaptive && !(d->time_budget > 0) && !d->depth && !d->normal && !d->albedo && !d->sample_count && !d->cost;
}

PKTRT_DEF pktrt_status pktrt_render_pass(const pktrt_scene *s, const pktrt_render_desc *d, uint32_t pass, uint32_t x,
                                         uint32_t y, uint32_t w, uint32_t h, double *means) {
  pktrt__render_state render;
  pktrt__refusal why;
  float none[3];
  if (!s || !d || !means) return PKTRT_INVALID_ARGUMENT;
  pktrt_render_desc own = *d;
  if (!own.pixels) own.pixels = none;
  if (!pktrt__render_check(s, &own, &render, &why) || !pktrt__pass_is_separate(d)) return PKTRT_INVALID_ARGUMENT;
  if (!pktrt__pass_is_within(d, x, y, w, h) || pass >= render.most_passes) return PKTRT_INVALID_ARGUMENT;
  const uint32_t area[4] = {x, y, x + w, y + h};
  render.sums_only = true, render.most_passes = UINT32_MAX; /* sums are made of a single pass, too */
  return pktrt__pass_render_area(&render, area, pass, 1, means);
}

PKTRT_DEF void pktrt_add_pass(const double *means, size_t n, pktrt_pixel_sums *sums) {
  for (size_t i = 0; i < n; i++) pktrt__pass_add(means + 3 * i, sums[i].mean, &sums[i].squares);
}

/* Fills in what the passes of a whole picture leave behind, as if they had been rounds of this process. */
static void pktrt__pass_take_sums(pktrt__pass_rounds *t, uint32_t passes, const pktrt_pixel_sums *sums) {
  const pktrt_render_desc *d = t->render->desc;
  pktrt__pass_sums *p = t->render->passes;
  for (uint32_t y = 0; y < d->height; y++)
    for (uint32_t x = 0; x < d->width; x++) {
      const pktrt_pixel_sums *s = &sums[(size_t)y * d->width + x];
      pktrt__pass_write_mean(s->mean, passes, d->pixels + y * t->render->row_stride + (size_t)x * 3);
      if (!p) continue; /* of a single pass no error is known */
      pktrt__pixel_sums *own = &p->sums[(size_t)y * d->width + x];
      memcpy(own->mean, s->mean, sizeof own->mean), own->squares = s->squares;
    }
  for (uint64_t i = 0; p && i < (uint64_t)p->cell_columns * p->cell_rows; i++) p->cells[i].more = passes;
  pktrt__pass_end_round(t);
  t->report.rounds = passes;
  if (p) pktrt__pass_estimate(t->render, t->spent, &t->report);
  t->report.stop = pktrt__pass_judge(t);
}

PKTRT_DEF pktrt_status pktrt_finish_passes(pktrt_scene *s, const pktrt_render_desc *d, uint32_t passes,
                                           const pktrt_pixel_sums *sums) {
  if (!s) return PKTRT_INVALID_ARGUMENT;
  s->error[0] = 0;
  pktrt__render_state render;
  pktrt__pass_sums own;
  pktrt__pass_rounds t;
  pktrt__refusal why;
  if (!pktrt__render_check(s, d, &render, &why)) return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "passes: %s", why.text);
  if (!pktrt__pass_is_separate(d))
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT,
                       "passes: adaptive, time_budget and optional buffers need pktrt_render");
  if (!sums || !passes || passes > render.most_passes)
    return pktrt__fail(s, PKTRT_INVALID_ARGUMENT, "passes: %s, %u of 1 to %u passes", sums ? "sums" : "no sums",
                       (unsigned)passes, (unsigned)render.most_passes);
  const uint32_t area[4] = {0, 0, d->width, d->height};
  if (!pktrt__pass_make(&render, area, &own))
    return pktrt__fail(s, PKTRT_OUT_OF_MEMORY, "passes: no memory for the sums of %u x %u pixels", (unsigned)d->width,
                       (unsigned)d->height);
  pktrt__pass_start(&render, &t);
  pktrt__pass_take_sums(&t, passes, sums);
  if (d->pixel_error || d->block_error) pktrt__pass_write_errors(&render);
  if (d->report) *d->report = t.report;
  if (render.passes) pktrt__pass_free(&s->desc, &own);
  return PKTRT_OK;
}
#endif /* PKTRT_NO_RENDER */

/* >>reporting ------------------------------------------------------------------------------------------------------ */

#define PKTRT__FEATURE_NAME(id, name, without, part_of) {PKTRT_FEATURE_##id, name},
static const struct pktrt__feature_row {
  uint32_t bit;
  const char *name;
} pktrt__feature_rows[] = {PKTRT__FEATURE_ROWS(PKTRT__FEATURE_NAME)};
enum { PKTRT__FEATURES = sizeof pktrt__feature_rows / sizeof *pktrt__feature_rows };

PKTRT_DEF const char *pktrt_feature_string(pktrt_feature feature) {
  for (int i = 0; i < PKTRT__FEATURES; i++)
    if (pktrt__feature_rows[i].bit == (uint32_t)feature) return pktrt__feature_rows[i].name;
  return "unknown";
}

PKTRT__COLD void pktrt__report_meshes(const pktrt_scene *s, pktrt_scene_report *r) {
  for (uint32_t i = 0; i < s->mesh_count; i++) {
    const pktrt__mesh *m = &s->meshes[i];
    const uint64_t all = pktrt__mesh_floats(m) * sizeof(float), key = all / (m->key_count ? m->key_count : 1),
                   further = all - key;
    const uint64_t places = 1u + (m->pending != NULL), bends = 0u + (m->normals != NULL) + (m->pending_normals != NULL);
    r->positions += places * key, r->normals += bends * key, r->motion += (places + bends) * further;
    if (m->indices) r->indices += (uint64_t)m->triangle_count * 3 * sizeof(uint32_t);
    if (m->texcoords) r->texcoords += (uint64_t)m->vertex_count * 2 * sizeof(float);
  }
}

PKTRT__COLD void pktrt__report_trees(const pktrt_scene *s, pktrt_scene_report *r) {
  for (uint32_t i = 0; i < s->bvh_count; i++) {
    const pktrt__bvh *bvh = &s->bvhs[i];
    r->nodes += (uint64_t)bvh->node_count * PKTRT__NODE_BYTES,
        r->blocks += (uint64_t)bvh->block_count * PKTRT__BLOCK_BYTES;
    r->motion += (uint64_t)bvh->node_count * (bvh->node_bytes - PKTRT__NODE_BYTES);
    r->motion += (uint64_t)bvh->block_count * (bvh->block_bytes - PKTRT__BLOCK_BYTES);
    r->ids += (uint64_t)bvh->block_count * 8 * sizeof(uint32_t);
  }
}

PKTRT_DEF void pktrt_get_scene_report(const pktrt_scene *s, const struct pktrt_render_desc *d, pktrt_scene_report *r) {
  memset(r, 0, sizeof *r);
  r->built = PKTRT__BUILT;
  if (!s) return;
  pktrt_get_scene_info(s, &r->info);
  for (uint32_t i = 0; i < s->model_count + 3; i++) {
    const uint32_t other = i - s->model_count;
    const pktrt_scene *of = i < s->model_count ? s->models[i] : other == 0 ? s : other == 1 ? s->boxes : s->groups;
    if (of) pktrt__report_meshes(of, r), pktrt__report_trees(of, r);
  }
  for (uint32_t i = 0; i < s->instance_count; i++)
    r->instances += sizeof *s->instances + ((s->instances[i].keys ? 1u : 0u) + (s->instances[i].pending ? 1u : 0u)) *
                                               s->instances[i].key_count * 12 * sizeof(float);
  for (uint32_t i = 0; i < s->committed_meshes; i++) r->found |= pktrt__feature_of_mesh(s, i);
#ifdef PKTRT_NO_RENDER
  (void)d;
  r->found &= PKTRT__BUILT, r->used = r->found;
#else
  r->materials = s->material_count * sizeof *s->materials + s->light_count * sizeof *s->lights;
  r->found = pktrt__feature_of_scene(s) & PKTRT__BUILT;
  r->used = r->found & (PKTRT_FEATURE_MOTION | PKTRT_FEATURE_INSTANCES | PKTRT_FEATURE_GROUPS | PKTRT_FEATURE_REMOVAL);
  if (d) {
    r->found = pktrt__feature_of_render(s, d), r->used = pktrt__feature_used(d, r->found);
    const uint32_t waves = !(r->used & PKTRT__SPECULAR) ? 0 : r->used & PKTRT_FEATURE_DIELECTRIC ? 3 : 2;
    r->worker = sizeof(pktrt__tile) + waves * sizeof(pktrt__wave);
    const bool passes = d->passes > 1 || d->target_error > 0 || d->time_budget > 0 || (d->pass && !d->passes);
    if (passes) {
      const uint64_t e = PKTRT__PASS_CELL, cells = ((d->width + e - 1) / e) * ((d->height + e - 1) / e);
      r->passes = (uint64_t)d->width * d->height * sizeof(pktrt__pixel_sums) + cells * sizeof(pktrt__pass_cell);
    }
  }
#endif
  r->bytes = r->nodes + r->blocks + r->motion + r->positions + r->normals + r->texcoords + r->indices + r->ids +
             r->materials + r->instances;
}

/* Adds to a text of `used` characters, of which `room` are kept. */
PKTRT__COLD size_t pktrt__report_print(char *text, size_t room, size_t used, const char *format, ...) {
  va_list args;
  va_start(args, format);
  const int n = vsnprintf(used < room ? text + used : NULL, used < room ? room - used : 0, format, args);
  va_end(args);
  return used + (n > 0 ? (size_t)n : 0);
}

PKTRT__COLD size_t pktrt__report_print_features(char *text, size_t room, size_t used, const char *what, uint32_t bits) {
  const char *before = " ";
  used = pktrt__report_print(text, room, used, "%-10s", what);
  for (int i = 0; i < PKTRT__FEATURES; i++) {
    if (!(bits & pktrt__feature_rows[i].bit)) continue;
    used = pktrt__report_print(text, room, used, "%s%s", before, pktrt__feature_rows[i].name);
    before = ", ";
  }
  return pktrt__report_print(text, room, used, "%s\n", bits ? "" : " nothing");
}

PKTRT__COLD size_t pktrt__report_text(const pktrt_scene_report *r, char *text, size_t room) {
  const struct {
    const char *what;
    uint64_t bytes;
  } parts[] = {{"nodes", r->nodes},         {"blocks", r->blocks},
               {"positions", r->positions}, {"indices", r->indices},
               {"further keys", r->motion}, {"normals", r->normals},
               {"texcoords", r->texcoords}, {"instances", r->instances},
               {"names", r->ids},           {"materials, lights", r->materials}};
  uint32_t all = 0;
  for (int i = 0; i < PKTRT__FEATURES; i++) all |= pktrt__feature_rows[i].bit;
  size_t n = pktrt__report_print(text, room, 0, "kernels    %s\n", pktrt_isa_string(r->info.isa));
  n = pktrt__report_print(text, room, n, "meshes     %u, of these %u moving; %llu triangles\n",
                          (unsigned)r->info.mesh_count, (unsigned)r->info.moving_meshes,
                          (unsigned long long)r->info.triangles);
  n = pktrt__report_print_features(text, room, n, "found", r->found);
  n = pktrt__report_print_features(text, room, n, "runs", r->used);
  n = pktrt__report_print_features(text, room, n, "idle", r->built & ~r->used);
  n = pktrt__report_print_features(text, room, n, "not built", all & ~r->built);
  n = pktrt__report_print(text, room, n, "bytes      %llu", (unsigned long long)r->bytes);
  const double each = r->info.triangles ? (double)r->bytes / (double)r->info.triangles : 0;
  if (r->info.triangles) n = pktrt__report_print(text, room, n, ", %.1f for each triangle", each);
  const char *before = ": ";
  for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
    if (!parts[i].bytes) continue;
    n = pktrt__report_print(text, room, n, "%s%s %llu", before, parts[i].what, (unsigned long long)parts[i].bytes);
    before = ", ";
  }
  n = pktrt__report_print(text, room, n, "\n");
  if (r->worker) n = pktrt__report_print(text, room, n, "a worker   %llu bytes\n", (unsigned long long)r->worker);
  if (r->passes) n = pktrt__report_print(text, room, n, "passes     %llu bytes\n", (unsigned long long)r->passes);
  return n;
}

PKTRT_DEF size_t pktrt_scene_report_text(const pktrt_scene_report *r, char *text, size_t room) {
  return pktrt__report_text(r, text, room);
}

#if defined(PKTRT__X86) && defined(__GNUC__) && !defined(__clang__) && defined(__cplusplus)
#pragma GCC diagnostic pop
#endif
#if defined(PKTRT__FLOAT_CONTROL)
#pragma float_control(pop)
#elif defined(__clang__)
#pragma STDC FP_CONTRACT DEFAULT
#elif defined(__GNUC__) && !defined(__TINYC__)
#pragma GCC pop_options
#endif

#endif /* the public functions */
/* >>changes ----------------------------------------------------------------------------------------------------------

     0.15.6   Faster: incoherent rays that are rows, which are sorted as well; scenes that most rays leave, where rays are
              sorted by octants alone.
     0.15.5   Faster: streams, which find any hit without branches and record closest ones a block later; packets, which
              filter all triangles of a block before one is tested; incoherent rays, of which more are sorted at a time.
     0.15.4   Faster: pictures (AVX2), whose lanes are packed by one choice for all rows; hits, where their depths tell that
              doubles suffice.
     0.15.3   Faster: rays are set up and put in order with less work; moving frusta give up earlier.
     0.15.2   Faster: frusta of rays that end together are cones. Less code, which compiles faster: where there are vectors,
              they shade scalar scenes too, and AVX2 counts for AVX-512.
     0.15.1   Faster: frusta prefetch, and give up later where rays have many origins; shadow rays that end at surfaces.
     0.15.0   Faster: boxes for rays of one origin; builds, by a twelfth; pictures of glass that touches glass.
     0.14.0   Faster: ties and surfaces that rays leave are told apart eight rays at a time, the last occluder is asked first,
              rows are copied by vectors. PKTRT_BUILD_HIGH splits: large triangles at rest lie in several leaves.
     0.13.0   Passes made in several places: pktrt_render_pass, pktrt_add_pass, pktrt_finish_passes. Trees are split by all
              workers from the first level on.
     0.12.0   To look inside: pktrt_get_tree, pktrt_get_node; steps of the paper's path left out (paper_steps); events of leaves
              and trimming, with tree, packet, depth and rays tested, from renders as well; cost of pixels;
              PKTRT_SAMPLER_CUSTOM. Vectors of WebAssembly. Changed: `packet` of pktrt_render_desc gets a
              pktrt_packet.
     0.11.0   Light with less error: by solid angle, by lights and lobes together, environments by where they are bright
              (pktrt_prepare_environment), one light of many by a tree (PKTRT_LIGHTS_ONE); lights can be visible. Adaptive
              passes by cells of 4 x 4. Estimates tell their interval, and when they are not to be believed (trust_estimates).
              PKTRT_BRANCHING_FIRST.
     0.10.0   Groups of meshes with trees of their own, masks of meshes, instances and queries; pktrt_remove_mesh,
              pktrt_remove_instance, pktrt_set_enabled. Texture coordinates, cutouts; pktrt_surface, pktrt_spawn_at.
              Adaptive passes go to cells of 4 x 4 pixels; reports say how far to believe them, and unreliable ones end
              no render at its target.
     0.9.0    Models, and instances that place them and move: pktrt_add_model, pktrt_add_instance, pktrt_set_transform,
              pktrt_get_mesh_source.
     0.8.0    Hits are those of exact arithmetic on the floats that are given, t within 0.7 ulp, and each crossing belongs to
              one triangle: closed meshes with collapsed triangles do not leak, and can be asked what they contain.
              pktrt_intersect_after, pktrt_intersect_all, pktrt_winding. pktrt_spawn moves by the rounding of a point.
     0.7.0    The inside speaks one language, and editors see the kernels. Renamed: pktrt_report_text to
              pktrt_scene_report_text; uv of pktrt_points to barycentric; looks, names and what is `info` of
              pktrt_scene_report.
     0.6.0    Rays know the glasses that they are in. Marks outlive refits; stray vertices do not count. What is likely to be a
              mistake is said in the log. pktrt_make_ray, pktrt_camera_ray, pktrt_version.
     0.5      Sobol' points that err as little as points can; mesh lights sampled by what of them a point sees; samples drawn
              by 64. What moves costs rays that pass it next to nothing.
     0.4      What a scene has not got costs it nothing: features are found, told, and can be left out by switches.
     0.3      Rendering in passes that know their error: estimates, rules when to stop, adaptive passes.
     0.2      Pictures by Whitted and by distribution ray tracing, packet assembly, optional buffers.
     0.1      Meshes with motion, queries on two paths and five instruction sets, ray casting with shadows.

   What may change. While the first number is 0, a new second one may rename and remove, move what structs hold, and
   change hits and pictures by their last bits or more; its entry above says what programs have to change. A new third
   one corrects: names, structs and bits stay, but for those that were wrong. At any time: speed, memory, the words of
   errors and of the log, and all that begins with pktrt__ or PKTRT__. Structs of two versions do not mix: compile all
   files that exchange them with one header; pktrt_version tells that of the implementation.
*/
/* >>licence ----------------------------------------------------------------------------------------------------------

   This software is available under two licences. Choose whichever you prefer.

   ALTERNATIVE A: MIT licence

   Copyright (c) 2026 the pktrt developers

   Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
   documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
   rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to
   permit persons to whom the Software is furnished to do so, subject to the following conditions:

   The above copyright notice and this permission notice shall be included in all copies or substantial portions of
   the Software.

   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO
   THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
   AUTHORS OR COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT,
   TORT OR OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE
   SOFTWARE.

   ALTERNATIVE B: public domain (www.unlicense.org)

   This is free and unencumbered software released into the public domain.

   Anyone is free to copy, modify, publish, use, compile, sell, or distribute this software, either in source code
   form or as a compiled binary, for any purpose, commercial or non-commercial, and by any means.

   In jurisdictions that recognize copyright laws, the author or authors of this software dedicate any and all
   copyright interest in the software to the public domain. We make this dedication for the benefit of the public at
   large and to the detriment of our heirs and successors. We intend this dedication to be an overt act of
   relinquishment in perpetuity of all present and future rights to this software under copyright law.

   THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO
   THE WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE
   AUTHORS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR OTHERWISE,
   ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
*/
