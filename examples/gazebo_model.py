"""Write the motor plugin of an SDF model with the exported coefficients."""

from pathlib import Path

exported = Path("apc_8x6e_motor.sdf").read_text()
plugin = f"""<plugin name="front_left_motor" filename="gz-sim-multicopter-motor-model-system">
<jointName>rotor_0_joint</jointName>
<linkName>rotor_0</linkName>
<turningDirection>ccw</turningDirection>
<motorNumber>0</motorNumber>
<commandSubTopic>command/motor_speed</commandSubTopic>
<timeConstantUp>0.0125</timeConstantUp>
<timeConstantDown>0.025</timeConstantDown>
{exported}</plugin>
"""
Path("front_left_motor.sdf").write_text(plugin)
print("wrote front_left_motor.sdf")
