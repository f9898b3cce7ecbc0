#pragma once

// Every number that decides something in a rule, by stage: with its unit and its reason. What a
// user can set is a parameter (config.h); sizes of tables and of memory are beside what they
// describe.

namespace talus::kernels
{
// ---- Stage 1: reflections, see 1_buried_rays.h ----

/** A hit is on known ground if it is this near to it: range noise and a cell's own relief. */
constexpr float kOnGround_m = 0.1f;
/** A ray is buried if it passes this far below known ground: twice that. */
constexpr float kBuried_m = 0.2f;

// ---- Stage 2: poses that are corrected, and other floors, see 2_follow.h ----

/** One place in so many of the table of rays is looked at: some hundred hits are enough. */
constexpr int kOffsetOneIn = 16;
/** Of fewer hits nothing is said. */
constexpr int kFewestGroundHits = 24;
/** Ground is bare if nothing stands on it that is higher [steps]. */
constexpr float kBare_steps = 0.5f;
/** How finely heights are told apart at first: three bins hold what noise and slopes leave of one
 * offset; all bins what corrections of poses reach. */
constexpr float kOffsetBin_m = 0.04f;
/** The map follows larger offsets than this: what fusing smooths out is left to that. */
constexpr float kFollow_m = 0.02f;
/** An offset that changes by so much is another floor, unless it took as long as drift takes. */
constexpr float kOtherFloor_m = 1.28f, kDrift_mps = 0.05f;
/** The floor is another one if one hit in so many lies beyond all bins. */
constexpr int kOtherFloorOneIn = 3;

// ---- Stage 3: update ----

/** What is hit at most so far above a guess [steps] is the floor itself. */
constexpr float kFloorHit_steps = 0.5f;
/** How far behind a point that overhangs the rays below it ended at least: farther than range noise
 * and round sides put other hits on the same thing; and in whole rings at least so many. */
constexpr float kBehindOverhang_m = 0.2f;
constexpr int kBehindOverhang_rings = 2;

// ---- Persistence: what is hit while rays pass ----

/** The hit count of Cell::recent_hits: each frame in which the cell was hit while rays passed lower
 * adds kHitAdds, each in which rays passed takes one. The edges of things cover their cells in
 * part, so that rays pass most of the time. What moves on seldom leaves two hits close by. What is
 * cleared leaves one hit's worth: something was there. */
constexpr int kHitAdds = 9, kMostRecentHits = 31;
/** Two hits within five frames, and not long ago. */
constexpr int kHitLately = kHitAdds + 5;
/** What stands where the robot drove came there later: it moves, and has left in its own shadow,
 * too, when it was not hit for so many frames. */
constexpr int kFollowerLeaves_frames = 5;
/** A hit over bare ground counts by itself if so many others of its frame are so near to it and
 * above the ground: snow, rain and dust are single points. Else it counts after two such hits
 * lately. */
constexpr int kOthersBesideHit = 2, kBesideHit_cells = 2;
constexpr float kBesideHit_steps = 2.0f;
/** What is hit while rays pass below it, a hedge, a railing, a branch, a bench, is no more gone
 * when rays pass there: it stays for so many frames without a hit. What is hit in one frame after
 * the other earns less: the long side of a thing that drives past is. */
constexpr int kPorousHitEarns = 3, kHeldHitEarns = 1;
/** From so many frames on it is porous, and a frame without a hit takes one; it cannot earn more
 * than kMostStay. */
constexpr int kPorousStay = 12, kMostStay = 120;
/** That little but what overhangs earns, and hedges and railings in time. */
constexpr int kOverhangStay = kMostStay / 2;

// ---- Stage 4: what is ground, and what stands ----

/** What lies so much above the plane on which the robot stands [steps] it drives through. */
constexpr float kUnderFoot_steps = 0.75f;
/** What it drove through is known to this height [steps]: blades stand up again. */
constexpr float kStandsUp_steps = 0.5f;
/** So far around its base the robot stands. */
constexpr float kFootprint_m = 0.25f;
/** The ground on which it starts is presumed so far around it at most, unless a user says so, and
 * only where ground is seen within that: what a beam 15 degrees down, 0.8 m high, leaves blind. */
constexpr float kStartsWithin_m = 3.0f;
/** Somebody put it there, with room to move off: so far the scanner need not look over. */
constexpr float kStartsOn_m = 0.7f;
/** It ends where the ray that leaves it blind would meet it, if that goes on to so far below it
 * [steps]: there is a drop-off somewhere. */
constexpr float kStartUndercut_steps = 1.0f;
/** A drop-off is where the lowest ray there passed by so large a share of that below the ground. */
constexpr float kStartDropSeen = 0.5f;
/** The z axis of a scanner that is upright points up by this at least: it leans by 60 degrees. */
constexpr float kUprightScanner = 0.5f;
/** Nor is ground presumed so far beside a direction in which there is a drop-off, as a share of the
 * distance. */
constexpr float kDropBeside = 0.2f;
/** How well the ground under the robot is known. */
constexpr float kUnderFoot_var_m2 = 0.02f * 0.02f;

/** What stands at least so high [steps] is upright: a column that others may be joined to, and a
 * face whose lowest hit need not be its foot. */
constexpr float kUpright_steps = 1.5f;
/** The underside of what overhangs may be so much above the robot [steps] and still be a face. */
constexpr float kFaceAboveRobot_steps = 0.5f;
/** Ground may be so much higher than the cone of the steepest slope over ground close by [steps]
 * ... */
constexpr float kAboveCone_steps = 0.25f;
/** ... and than the opening of the ground around it. */
constexpr float kAboveOpening_steps = 0.5f;
/** The cone is as steep as this [m/m], or as what the robot climbs: 45 degrees, as steep as banks
 * are. */
constexpr float kSteepestBank = 1.0f;
/** What stands higher than this [clearances] over its ground is no roof that was hit for the first
 * time. */
constexpr float kStandsAlready_clearances = 0.5f;
/** What stands beside an object goes on past it if it is so much higher [steps]. */
constexpr float kPastObject_steps = 0.5f;
/** Tops belong to one thing if they differ by at most so much [steps]. */
constexpr float kSameThing_steps = 0.5f;
/** A face is looked for in so many corridors towards the sensor, a pair of cells wide each, of
 * which so many may be without it: wider than the leg of a table. */
constexpr int kFaceCorridors = 5, kMissingCorridors = 1;

// ---- Stages 4 and 5: rays of one cell ----

/** Of the angle under which the sensor sees a cell its middle half is looked at: an eighth of a
 * side of the square in either direction, over the ring. */
constexpr float kFootprintHalfSpan = 0.125f;
/** Rays count for a cell if they ended so many rings behind it: not on the thing itself. */
constexpr int kBehindCell_rings = 2;
/** Nearer to the sensor than this a cell is seen from above only. */
constexpr float kUnderSensor_rings = 2.0f;
/** Rays are looked at in so many directions more on either side of a cell: beside the edge of what
 * stands there some go on. */
constexpr int kBesideCell_bins = 2;
/** Hits so many rings before a cell still belong to what overhangs in it, which is seldom one cell
 * wide. */
constexpr int kBeforeCell_rings = 2;

// ---- Stage 6: lines ----

/** Where a ray seems to have passed this far below a sample, one of the two is wrong: the thing is
 * gone, or the ray is that of a reflection. Until it is known which, fills beside the sample do not
 * believe their rays. */
constexpr float kContradicted_m = 0.1f;
/** Where rays undercut by this the ground that goes on level from a sample a drop-off lies
 * somewhere between, and the cells before that place are not judged either. Lines from the sensor
 * are asked at each so many places. */
constexpr float kUndercutAhead_m = 0.1f;
constexpr int kUndercutPlaces = 4;
/** Wider gaps may hold a face: the front of something, or the edge of a drop. */
constexpr float kFaceGap_m = 0.3f;
/** What any line is off by, however short: of this size it makes short lines count nearly alike, so
 * that their noise averages out. */
constexpr float kLineDeviation_m = 0.080f;
/** Nobody knows where in a gap ground rises that does not rise as it does around the robot: the
 * deviation of what is one height or the other, by their difference, 1 / sqrt(12). */
constexpr float kRiseDeviation = 0.289f;
/** What lies between two samples is off by this share of their reduced distance, a b / (a + b)
 * [m/m]; beside one by this share of its distance. */
constexpr float kBetweenDeviation = 0.1f, kBeyondDeviation = 0.3f;
/** Heights of neighbouring cells differ by so much for noise alone. */
constexpr float kHeightNoise_m = 0.002f;
/** Ground goes on so many times as far off the mean as the nearest sample is, but at most by this
 * share of a step: a nearest sample that is farther off is the foot of something. */
constexpr float kGoesOn = 2.0f, kGoesOnMost_steps = 0.25f;
/** A fill may lie too high, so that it counts so much above the lowest of its lines [steps]. */
constexpr float kAboveLowestLine_steps = 0.25f;
/** An object hangs if it is so high above what is filled below it [clearances]: on nothing, or
 * beside a column, which may hold it. */
constexpr float kHangs_clearances = 1.0f, kHangsBesideColumn_clearances = 2.0f;

// ---- Stage 7 ----

/** A step that the robot takes for sure, within two cells [steps]. */
constexpr float kLowStep_steps = 0.8f;
/** A cell at the edge of what is impassable joins it if the surface rises this many times as
 * steeply as it may count: two cells alone tell a slope badly. */
constexpr int kSteepEdge = 3;

/** Where a ray passed so far above a fill from two sides [steps] nothing higher stands: it is
 * judged, but no better than this. */
constexpr float kPassedNear_steps = 2.5f, kPassedNearScore = 0.5f;
/** What the robot drove through is at least so traversable, whatever stands beside it. */
constexpr float kDrivenScore = 0.5f;

// ---- Stage 7 ----

/** A slope of this share of what is allowed explains what ground falls by in a gap, but no more
 * than so many steps: the floor behind the crest of a ramp, not that below a dock. */
constexpr float kExplainedSlope = 0.5f, kExplained_steps = 2.5f;
/** The far wall of a ditch rises by so much more than a robot can drive; a ditch is not wider. */
constexpr float kWallNoise_m = 0.01f, kWidestDitch_m = 2.8f;
/** Ground that falls so little [m/m] is level. */
constexpr float kGentle = 0.05f;
/** A ditch may be so many times as deep as its far wall begins below the near edge. */
constexpr float kHollow = 2.0f;
/** Ground may drop where eq. 14 says less than this: halfway between sure and out of the question.
 */
constexpr float kSparse = 0.5f;

}  // namespace talus::kernels
