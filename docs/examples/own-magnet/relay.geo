// Half of a relay, y >= 0, in mm: a core in its coil, a yoke whose leg goes through to the armature (the closed leg),
// one gap above the core. Change the numbers here or with -setnumber, then:
//   gmsh -3 -format msh41 relay.geo -o relay.msh
SetFactory("OpenCASCADE");
DefineConstant[
  gap = 1,        // between the faces, as drawn
  size = 1.25,    // of all tetrahedra
  core = 10,      // width of the core, along x
  window = 14,    // between core and leg
  leg = 8,        // width of the leg
  depth = 12,     // of all iron, along y
  height = 30,    // of the window
  yoke = 6,       // height of yoke and armature
  bobbin = 2,     // between core and coil, and at its ends
  winding = 10,   // width of the coil
  reach = 60      // of the air around
];
x1 = core / 2; x2 = x1 + window; x3 = x2 + leg; y1 = depth / 2;
in_x = x1 + bobbin; in_y = y1 + bobbin; out_x = in_x + winding; out_y = in_y + winding;
low = -height + bobbin; high = -bobbin;

// fixed iron: the core is cut where the coil ends
Box(1) = {-x1, 0, -height - yoke, x1 + x3, y1, yoke};
Box(2) = {-x1, 0, -height, core, y1, low + height};
Box(3) = {-x1, 0, low, core, y1, high - low};
Box(4) = {-x1, 0, high, core, y1, -high};
Box(5) = {x2, 0, -height, leg, y1, height};
// the armature, and what of the leg stretches
Box(6) = {-x1, 0, gap, x1 + x3, y1, yoke};
Box(7) = {x2, 0, 0, leg, y1, gap};

// the coil, with round corners outside
Point(1001) = {in_x, 0, low};
Point(1002) = {out_x, 0, low};
Point(1003) = {out_x, in_y, low};
Point(1004) = {in_x, out_y, low};
Point(1005) = {-in_x, out_y, low};
Point(1006) = {-out_x, in_y, low};
Point(1007) = {-out_x, 0, low};
Point(1008) = {-in_x, 0, low};
Point(1009) = {-in_x, in_y, low};
Point(1010) = {in_x, in_y, low};
Line(1001) = {1001, 1002};
Line(1002) = {1002, 1003};
Circle(1003) = {1003, 1010, 1004};
Line(1004) = {1004, 1005};
Circle(1005) = {1005, 1009, 1006};
Line(1006) = {1006, 1007};
Line(1007) = {1007, 1008};
Line(1008) = {1008, 1009};
Line(1009) = {1009, 1010};
Line(1010) = {1010, 1001};
Curve Loop(1001) = {1001 : 1010};
Plane Surface(1001) = {1001};
coil() = Extrude{0, 0, high - low}{ Surface{1001}; };

// its opening, beside the core
Box(90) = {-in_x, 0, low, 2 * in_x, in_y, high - low};
opening() = BooleanDifference{ Volume{90}; Delete; }{ Volume{3}; };

Box(99) = {-out_x - reach, 0, -height - yoke - reach, out_x + x3 + 2 * reach, out_y + reach,
           height + gap + 2 * yoke + 2 * reach};
all() = BooleanFragments{ Volume{99}; Delete; }{ Volume{1 : 7, coil(1), opening()}; Delete; };
air() = all();
air() -= {1 : 7, coil(1), opening()};

// a shape keeps its number; what is new is air
Physical Volume("core") = {1 : 5};
Physical Volume("armature") = {6};
Physical Volume("hinge") = {7};
Physical Volume("coil") = {coil(1)};
Physical Volume("bobbin") = {opening()};
Physical Volume("air") = {air()};

// sizes: beside the edges of the pole, in the gap, in the iron, in the air
e = 0.01;
edges() = Curve In BoundingBox{-x1 - e, -e, -e, -x1 + e, y1 + e, gap + e};
edges() += Curve In BoundingBox{x1 - e, -e, -e, x1 + e, y1 + e, gap + e};
edges() += Curve In BoundingBox{-x1 - e, y1 - e, -e, x1 + e, y1 + e, gap + e};
Field[1] = Distance; Field[1].CurvesList = {edges()}; Field[1].NumPointsPerCurve = 40;
Field[2] = Threshold; Field[2].InField = 1;
Field[2].SizeMin = 0.5 * size; Field[2].SizeMax = 30 * size; Field[2].DistMin = 0.3; Field[2].DistMax = 50;
Field[3] = Box; Field[3].VIn = 1.8 * size; Field[3].VOut = 30 * size; Field[3].Thickness = 60;
Field[3].XMin = -x1; Field[3].XMax = x1; Field[3].YMin = 0; Field[3].YMax = y1;
Field[3].ZMin = 0; Field[3].ZMax = gap;
Field[4] = Box; Field[4].VIn = 4 * size; Field[4].VOut = 30 * size; Field[4].Thickness = 80;
Field[4].XMin = -out_x; Field[4].XMax = x3; Field[4].YMin = 0; Field[4].YMax = out_y;
Field[4].ZMin = -height - yoke; Field[4].ZMax = gap + yoke;
Field[5] = Min; Field[5].FieldsList = {2, 3, 4};
Background Field = 5;
Mesh.MeshSizeExtendFromBoundary = 0; Mesh.MeshSizeFromPoints = 0; Mesh.MeshSizeMax = 30 * size;
Mesh.Optimize = 1;
