#pragma once

// Every number that decides something in a rule, by stage, with its unit and its reason. Parameters
// of the user are in config.h; sizes of tables and memory are where they are used.

namespace talus::kernels
{
// ---- Stage 1: reflections, see 1_buried_rays.h ----

/** A hit is on known ground if it is this near to it: range noise and a cell's own relief. */
constexpr float kOnGround_m = 0.1f;
/** A ray is buried if it passes this far below known ground: twice kOnGround_m. */
constexpr float kBuried_m = 0.2f;

// ---- Stage 2: poses that are corrected, and other floors, see 2_follow.h ----

constexpr int kOffsetOneIn = 16;  //!< one hit in kOffsetOneIn is sampled: some hundred are enough
constexpr int kMinGroundHits = 24;  //!< fewer ground hits decide nothing
/** Ground is bare if nothing stands on it that is higher [steps]. */
constexpr float kBare_steps = 0.5f;
/** Width of a bin of the histogram: three hold one offset's noise, all of them pose corrections. */
constexpr float kOffsetBin_m = 0.04f;
/** The datum follows larger offsets only: fusion smooths out smaller ones. */
constexpr float kFollow_m = 0.02f;
/** Ground that is off by this much, beyond all bins, is another floor. */
constexpr float kOtherFloor_m = 1.28f;
/** The floor is another one if one hit in kOtherFloorOneIn lies beyond all bins. */
constexpr int kOtherFloorOneIn = 3;

// ---- Stage 3: update ----

/** Rays that show an overhang end at least this far behind the point, and this number of whole
 * rings: range noise and round sides put hits on the same object nearer. */
constexpr float kBehindOverhang_m = 0.2f;
constexpr int kBehindOverhang_rings = 2;

// ---- Persistence: hits while rays pass ----

/** Cell::recent_hits: each frame with a hit above passing rays adds kHitAdds, each frame of passing
 * rays takes one. Edges cover their cells in part, so that rays pass most of the time. A mover
 * seldom leaves two hits close together. A cleared cell keeps one hit, see object_left(). */
constexpr int kHitAdds = 9, kMaxRecentHits = 31;
constexpr int kLoneHitCounts = kHitAdds + 5;  //!< two hits within five frames, and not long ago
/** An object where the robot drove appeared later, so it moves: it is gone, occluded or not, after
 * this number of frames without a hit. */
constexpr int kFollowerLeaves_frames = 5;
/** A hit over bare ground counts by itself if this number of other hits above the ground is near:
 * snow, rain and dust are single points. Otherwise two such hits in recent frames count. */
constexpr int kOthersBesideHit = 2, kBesideHit_cells = 2;
constexpr float kBesideHit_steps = 2.0f;
/** Frames of rays below it, without a hit, for which an overhang (bench, railing, branch) stays. */
constexpr int kOverhangStays_frames = 108;
/** An object stays as a whole: a cell that rays pass waits while one this near is hit above them.
 * Hits on a round trunk or a hedge lie within two cells of its rim. */
constexpr int kRim_cells = 2;
/** An object goes as a whole: pairs around that show that an overhang left, 0.7 m in all. */
constexpr int kLeavesTogether_pairs = 3;

// ---- Stage 4: ground or object ----

/** The robot drives through an object lower than this above its plane [steps]. */
constexpr float kUnderFoot_steps = 0.75f;
/** Margin above the height that it drove through [steps]: blades stand up again. */
constexpr float kStandsUp_steps = 0.5f;
constexpr float kFootprint_m = 0.25f;  //!< the robot stands on this radius around its base
/** In the automatic mode ground is presumed within this distance of the start, and only where
 * ground is seen within it: the blind zone of a beam 15 degrees down, 0.8 m high. */
constexpr float kStartsWithin_m = 3.0f;
/** So near to the start ground is presumed in any case: the robot was put there to move off. */
constexpr float kStartsOn_m = 0.7f;
/** There may be a drop-off if the ray above the blind zone goes on this deep below it [steps]. */
constexpr float kStartUndercut_steps = 1.0f;
/** There is a drop-off if the lowest ray there passed this share of that depth below the ground. */
constexpr float kStartDropSeen = 0.5f;
/** An upright scanner's z axis has at least this z component: it leans by up to 60 degrees. */
constexpr float kUprightScanner = 0.5f;
/** Ground is not presumed within this share of the distance beside a direction with a drop-off. */
constexpr float kDropBeside = 0.2f;
constexpr float kUnderFoot_var_m2 = 0.02f * 0.02f;  //!< variance of the ground under the robot

/** An object at least this high [steps] is upright: its lowest hit need not be its foot. */
constexpr float kUpright_steps = 1.5f;
/** A passable cell that is not reached is the top of an object where it lies this far above a cone
 * of the slope that the robot climbs over the reached ground around it [steps]. */
constexpr float kApart_steps = 1.0f;
/** Ground may lie this far above the cone of the steepest slope over ground close by [steps] ... */
constexpr float kAboveCone_steps = 0.25f;
/** ... and than the opening of the ground around it. */
constexpr float kAboveOpening_steps = 0.5f;
/** Pairs by which dilation goes farther than erosion: a pair with an edge and the ground below it
 * belongs to the platform of that edge. */
constexpr int kDilatesFarther_pairs = 1;
/** Min score of a guess that reach goes over: a steeper one may lead from the floor onto a box. */
constexpr float kGuessScore = 0.8f;
/** Variance of the ground below an object that is as high as the ground around it. */
constexpr float kFoot_var_m2 = 0.15f * 0.15f;
/** In the first frame ground is reached up to this number of heights of the sensor away, where the
 * lowest beam of most scanners (15 degrees) meets it, and this far off the base's plane [steps]. */
constexpr float kStartReach = 4.0f, kStartReach_steps = 0.5f;
/** Rounds of four sweeps of reach in the first frame: 7 to 12 cross a street of parked cars. */
constexpr int kFirstReach_rounds = 12;
/** The cone is as steep as this [m/m], or as what the robot climbs: 45 degrees, as banks are. */
constexpr float kSteepestBank = 1.0f;

// ---- Stages 4 and 5: rays of one cell ----

/** Half of a cell's angle for its rays, its middle half: an eighth of a side, over the ring. */
constexpr float kFootprintHalfSpan = 0.125f;
/** Rays of a cell ended this number of rings behind it, so not on the object itself. */
constexpr int kBehindCell_rings = 2;
constexpr float kUnderSensor_rings = 2.0f;  //!< nearer to the sensor a cell is seen from above only
/** Hits within these rings before a cell belong to its overhang, which is seldom one cell wide. */
constexpr int kBeforeCell_rings = 2;

/** Rays below ground do not count if others within this distance on both sides pass above it, see
 * passes_over(): where a fifth of a floor's returns is reflected, those of 4 cells may all be. */
constexpr int kBesideRay_cells = 6;

// ---- Stage 6: lines ----

/** Where a ray ended, and how gently [m/m] and how far up ground leads there, noise aside: beyond
 * 1 m more steeply, since hills are round, by kHill_m at most. Beyond a sample that lies higher
 * there is a drop-off, and a guess that lies higher is not free: both are behind an edge, or in a
 * ditch. */
constexpr float kEndsBelow_m = 0.05f, kEndsFall = 0.15f, kEndsFarFall = 0.25f, kEndsRise_m = 1.0f;
constexpr float kHill_m = 0.6f;
/** Stride at which a line from the sensor is searched for drop-offs. */
constexpr int kDropStride_cells = 4;
/** Deviation of any line, however short, so that the noise of short lines averages out. */
constexpr float kLineDeviation_m = 0.080f;
/** Ground may rise anywhere in a gap: the deviation, by the height difference, of a uniform
 * distribution, 1 / sqrt(12). */
constexpr float kRiseDeviation = 0.289f;
/** The deviation between two samples is this share of their reduced distance, a b / (a + b) [m/m];
 * beside one it is this share of its distance. */
constexpr float kBetweenDeviation = 0.05f, kBeyondDeviation = 0.3f;
constexpr float kFillLines = 3.0f;  //!< the lines of a fill: from the sensor, row and column
/** The standard deviation of a fill grows by this share of the height of the mean of its lines
 * above the lowest: fitted, with fill_variance_per_m, to the errors of fills. */
constexpr float kLinesApart = 0.5f;
/** A fill may lie too high. Where that matters, below an object and where rays prove it to be free,
 * it lies at most this far above the lowest of its lines [steps]. */
constexpr float kAboveLowestLine_steps = 0.25f;
/** This near to an object lower than the clearance, only rays as low as a step prove that a cell is
 * free: it may be the hidden side of the object. */
constexpr float kBesideThing_m = 0.5f;
/** A fill between known ground is free if rays passed so low [steps]: of 32 beams 0.2 to 0.4 m. */
constexpr float kFreeBetween_steps = 2.5f;

// ---- Stage 7 ----

/** A step that the robot takes for sure, within two cells [steps]. */
constexpr float kLowStep_steps = 0.8f;
/** A cell beside an impassable one joins it if its score is less: halfway to impassable. */
constexpr float kEdgeScore = 0.5f;

constexpr float kDrivenScore = 0.5f;  //!< min score where the robot drove, also beside an object

// ---- Stage 7: drops ----

/** A slope of this share of the limit explains a fall in a gap, up to this number of steps: the
 * floor behind the crest of a ramp, not that below a dock. */
constexpr float kExplainedSlope = 0.5f, kExplained_steps = 2.5f;
/** The far wall of a ditch rises by this much more than a robot can drive; max width of a ditch. */
constexpr float kWallNoise_m = 0.01f, kWidestDitch_m = 2.8f;
constexpr float kGentle = 0.05f;  //!< ground that falls by less than this [m/m] is level
/** Max depth of a ditch over the depth at which its far wall begins below the near edge. */
constexpr float kDitchDepthFactor = 2.0f;
/** Ground may drop if eq. 14 gives less than this: halfway between sure and impossible. */
constexpr float kSparse = 0.5f;

// ---- Channels ----

/** Max past points in a mean, so that it follows change within a few scans of 1 to 10 points. */
constexpr std::uint32_t kMeanOfPoints = 64;
/** Votes are halved above this number, for the same reason; each fits into eight bits. */
constexpr std::uint32_t kVotesOfPoints = 64;
/** Values are summed in units of 1/65536; left out beyond 2^24, where float has no fractions. */
constexpr double kChannelUnits = 65536.0;
constexpr float kMaxChannelValue = 16777216.0f;

}  // namespace talus::kernels
