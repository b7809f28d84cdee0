#pragma once

namespace handgraft::fuzz {

/// A URDF with a revolute joint, a continuous one, and a slider that follows the first.
inline constexpr const char* kSmallHand = R"(<robot name="hand">
<link name="palm"><visual><geometry><box size="0.1 0.1 0.02"/></geometry></visual></link>
<link name="low"/><link name="tip"><visual><geometry><sphere radius="0.01"/></geometry></visual>
</link><link name="other"/>
<joint name="j" type="revolute"><parent link="palm"/><child link="low"/><axis xyz="0 1 0"/>
<origin xyz="0.05 0 0"/><limit lower="-0.5" upper="1.5" effort="1" velocity="1"/></joint>
<joint name="k" type="continuous"><parent link="low"/><child link="tip"/><axis xyz="0 1 0"/>
<origin xyz="0.03 0 0"/></joint>
<joint name="m" type="prismatic"><parent link="palm"/><child link="other"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0.1" effort="1" velocity="1"/><mimic joint="j" multiplier="0.1"/></joint>
</robot>)";

}  // namespace handgraft::fuzz
